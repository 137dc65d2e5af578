"""Each step satisfies the equations that the full simulator solves, written out plainly here."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from reduced_models import Model, linear, stiffening

from fenics_defo.runtime.integrators import (
    BackwardEuler,
    CentralDifferences,
    ImplicitNewmark,
    SymplecticEuler,
)

Array = NDArray[np.float64]
STEP = 0.05
DAMPINGS = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.02), (0.4, 0.03)]
State = tuple[Array, Array, Array]


def load_at(model: Model, time: float) -> Array:
    return np.asarray(3.0 * np.sin(5.0 * time + np.arange(model.size)))


def first_state(model: Model, damping: tuple[float, float]) -> State:
    rng = np.random.default_rng(9)
    q, v = 0.2 * rng.normal(size=model.size), rng.normal(size=model.size)
    alpha, beta = damping
    c = alpha * model.mass + beta * model.law.stiffness(q)
    rest = load_at(model, 0.0) - model.law.force(q) - c @ v
    return q, v, np.linalg.solve(model.mass, rest)


def implicit(
    model: Model,
    state: State,
    load: Array,
    damping: tuple[float, float],
    *,
    newton: int,
    beta: float | None,
    gamma: float = 0.5,
) -> State:
    """One step of Newmark's method, or of Euler's for beta = None, by Newton's iterations."""
    (q0, v0, a0), (alpha, drag), h = state, damping, STEP
    q = q0
    for _ in range(newton + 1):
        if beta is None:
            v = (q - q0) / h
            a = (v - v0) / h
            rates = 1.0 / h, 1.0 / h**2
        else:
            a = (q - q0 - h * v0) / (beta * h**2) - (0.5 / beta - 1.0) * a0
            v = v0 + h * ((1.0 - gamma) * a0 + gamma * a)
            rates = gamma / (beta * h), 1.0 / (beta * h**2)
        k = model.law.stiffness(q)
        c = alpha * model.mass + drag * k
        residual = model.mass @ a + c @ v + model.law.force(q) - load
        reached = q, v, a
        q = q - np.linalg.solve(rates[1] * model.mass + rates[0] * c + k, residual)
    return reached


def central(model: Model, state: State, load: Array, damping: tuple[float, float]) -> State:
    """The mass part of the damping at the end of the step, its stiffness part at the middle."""
    (q, v, a), (alpha, beta), h = state, damping, STEP
    w = v + 0.5 * h * a
    q = q + h * w
    force = load - model.law.force(q) - beta * model.law.stiffness(q) @ w - alpha * model.mass @ w
    a = np.linalg.solve((1.0 + 0.5 * h * alpha) * model.mass, force)
    return q, w + 0.5 * h * a, a


def symplectic(model: Model, state: State, load: Array, damping: tuple[float, float]) -> State:
    (q, v, _), (alpha, beta), h = state, damping, STEP
    force = load - model.law.force(q) - beta * model.law.stiffness(q) @ v - alpha * model.mass @ v
    a = np.linalg.solve((1.0 + h * alpha) * model.mass, force)
    v = v + h * a
    return q + h * v, v, a


CASES: dict[str, tuple[Any, dict[str, Any], Any, dict[str, Any]]] = {
    "newmark": (ImplicitNewmark, {}, implicit, {"newton": 1, "beta": 0.25}),
    "newmark two": (ImplicitNewmark, {"newton": 2}, implicit, {"newton": 2, "beta": 0.25}),
    "newmark three": (ImplicitNewmark, {"newton": 3}, implicit, {"newton": 3, "beta": 0.25}),
    "newmark damped": (
        ImplicitNewmark,
        {"beta": 0.4, "gamma": 0.7, "newton": 2},
        implicit,
        {"newton": 2, "beta": 0.4, "gamma": 0.7},
    ),
    "newmark converged": (
        ImplicitNewmark,
        {"newton": None, "newton_tolerance": 1e-13},
        implicit,
        {"newton": 9, "beta": 0.25},
    ),
    "euler": (BackwardEuler, {}, implicit, {"newton": 1, "beta": None}),
    "euler three": (BackwardEuler, {"newton": 3}, implicit, {"newton": 3, "beta": None}),
    "euler converged": (
        BackwardEuler,
        {"newton": None, "newton_tolerance": 1e-13},
        implicit,
        {"newton": 9, "beta": None},
    ),
    "central": (CentralDifferences, {"allow_unstable": True}, central, {}),
    "symplectic": (SymplecticEuler, {"allow_unstable": True}, symplectic, {}),
}
MODELS = {
    "full mass": stiffening(),
    "unit mass": stiffening(unit_mass=True),
    "linear": linear(),
    "modal": linear(kind="modal"),
}


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("which", MODELS)
def test_five_steps_are_those_of_the_equations(
    which: str, case: str, damping: tuple[float, float]
) -> None:
    model, (make, options, step, more) = MODELS[which], CASES[case]
    state = first_state(model, damping)
    motion = make(
        model,
        step=STEP,
        damping=damping,
        q=state[0],
        v=state[1],
        load=load_at(model, 0.0),
        **options,
    )
    np.testing.assert_allclose(motion.a, state[2], rtol=1e-11)
    # Converged steps end with the residual, not with the last digit.
    tolerance = 1e-8 if "converged" in case else 3e-12
    for number in range(1, 6):
        load = load_at(model, motion.load_time)
        motion.advance(load)
        state = step(model, state, load, damping, **more)
        for found, expected in zip((motion.q, motion.v, motion.a), state, strict=True):
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, atol=tolerance * scale, rtol=0.0)
        assert motion.steps == number
        assert motion.time == pytest.approx(number * STEP, rel=1e-15)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("which", MODELS)
def test_a_batch_moves_as_each_of_its_bodies(which: str, case: str) -> None:
    model, (make, options, *_) = MODELS[which], CASES[case]
    rng = np.random.default_rng(4)
    q, v = 0.2 * rng.normal(size=(2, 3, model.size))
    loads = rng.normal(size=(3, 3, model.size))
    options = {"step": STEP, "damping": (0.2, 0.01), "energies": True, **options}
    batch = make(model, q=q, v=v, **options)
    alone = [make(model, q=q[body], v=v[body], **options) for body in range(3)]
    for load in loads:
        batch.advance(load)
        for body, motion in enumerate(alone):
            motion.advance(load[body])
    for name in ("q", "v", "a"):
        expected = np.array([getattr(motion, name) for motion in alone])
        np.testing.assert_allclose(getattr(batch, name), expected, rtol=1e-10, atol=1e-12)
    for name in ("kinetic", "strain", "external", "dissipated"):
        expected = np.array([getattr(motion.energies, name) for motion in alone])
        np.testing.assert_allclose(getattr(batch.energies, name), expected, rtol=1e-10, atol=1e-12)


def test_one_load_for_all_bodies_of_a_batch() -> None:
    model = stiffening()
    load = np.arange(4.0)
    one, two = (ImplicitNewmark(model, step=STEP, batch=2) for _ in range(2))
    one.advance(load)
    two.advance(np.array([load, load]))
    np.testing.assert_array_equal(one.q, two.q)
    np.testing.assert_array_equal(one.q[0], one.q[1])
    assert np.abs(one.q).min() > 0.0
