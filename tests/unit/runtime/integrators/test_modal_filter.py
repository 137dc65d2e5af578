"""The recursive filter against closed forms of the damped oscillator."""

import math
from decimal import Decimal, localcontext
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from reduced_models import Model, linear, oscillator, stiffening

from fenics_defo.errors import DivergenceError, LoadError, SolverError
from fenics_defo.runtime.forces import LinearForce
from fenics_defo.runtime.integrators import ImplicitNewmark, ModalFilter
from fenics_defo.runtime.integrators.modal_response import modal_response

Array = NDArray[np.float64]


def exact(k: float, c: float, t: float) -> Array:
    """Rows z, v at t from z(0) = 1, from v(0) = 1, from p = 1 and from p = t.

    By the series of the matrix exponential of an ever smaller part of t, squared again and again,
    in decimal numbers of 90 digits.
    """
    with localcontext() as context:
        context.prec = 90
        k_, c_ = Decimal(k), Decimal(c)
        rows = [[0, 1, 0, 0], [-k_, -c_, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
        halvings = max(0, math.ceil(math.log2((1.0 + abs(k) + c) * t))) + 4
        part = np.array(rows, dtype=object) * (Decimal(t) / 2**halvings)
        term = total = np.array([[Decimal(int(i == j)) for j in range(4)] for i in range(4)])
        for n in range(1, 40):
            term = term @ part / n
            total = total + term
        for _ in range(halvings):
            total = total @ total
        return total[:2].astype(float)


CASES = {
    "under": (9.0, 0.6, 0.3),
    "slightly": (9.0, 1e-6, 0.3),
    "many periods": (9.0, 0.01, 1000.3),
    "nearly critical, below": (9.0, 5.9, 0.7),
    "nearly critical, above": (9.0, 6.1, 0.7),
    "nearly critical, long": (9.0, 6.01, 5.0),
    "over": (9.0, 60.0, 0.3),
    "far over": (9.0, 6e5, 0.3),
    "far over, long": (9.0, 6e4, 3e3),
    "free and damped": (0.0, 2.0, 0.3),
    "free and damped, long": (0.0, 2.0, 30.0),
    "soft": (1e-3, 0.5, 30.0),
    "unstable": (-4.0, 0.7, 1.5),
    "unstable and far over": (-4.0, 90.0, 0.5),
    "stiff": (1e12, 0.0, 1e-4 / 3.0),
}


@pytest.mark.parametrize("case", CASES)
def test_coefficients_are_the_closed_forms(case: str) -> None:
    k, c, h = CASES[case]
    found = modal_response(np.array([k]), np.array([c]), h)
    expected = exact(k, c, h) / [1.0, 1.0, 1.0, h]
    got = np.array(
        [
            [found.z_of_z, found.z_of_v, found.z_of_load, found.z_of_ramp],
            [found.v_of_z, found.v_of_v, found.v_of_load, found.v_of_ramp],
        ]
    )[:, :, 0]
    # Oscillations pass through zero, and a phase is known no better than its argument.
    omega = math.sqrt(abs(k)) or 1.0
    phase = max(1.0, omega * h) if c < 2.0 * omega and k > 0.0 else 0.0
    size = np.array(
        [[1.0, 1.0 / omega, omega**-2, omega**-2], [omega, 1.0, 1.0 / omega, omega**-2 / h]]
    )
    off = np.abs(got - expected)
    assert (off <= 1e-13 * np.abs(expected) + 3e-16 * phase * size).all(), off / np.abs(expected)


def test_critical_damping_and_no_force_at_all() -> None:
    omega, h = 3.0, 0.4
    found = modal_response(np.array([omega**2, 0.0]), np.array([2.0 * omega, 0.0]), h)
    fade = math.exp(-omega * h)
    np.testing.assert_allclose(found.z_of_z, [fade * (1.0 + omega * h), 1.0], rtol=1e-14)
    np.testing.assert_allclose(found.z_of_v, [fade * h, h], rtol=1e-14)
    np.testing.assert_allclose(found.v_of_v, [fade * (1.0 - omega * h), 1.0], rtol=1e-13)
    np.testing.assert_allclose(found.z_of_load[1], h**2 / 2.0, rtol=1e-15)
    np.testing.assert_allclose(found.z_of_ramp[1], h**2 / 6.0, rtol=1e-15)


@given(
    log_k=st.floats(-12.0, 12.0),
    log_c=st.floats(-12.0, 12.0),
    sign=st.sampled_from([0.0, 1.0]),
)
def test_two_steps_are_one_of_twice_the_length(log_k: float, log_c: float, sign: float) -> None:
    k, c = np.array([sign * 10.0**log_k]), np.array([10.0**log_c])
    once, twice = modal_response(k, c, 1.0), modal_response(k, c, 2.0)
    step = np.array(
        [
            [once.z_of_z, once.z_of_v, once.z_of_load],
            [once.v_of_z, once.v_of_v, once.v_of_load],
            [[0.0], [0.0], [1.0]],
        ]
    )[:, :, 0]
    expected = np.array(
        [
            [twice.z_of_z, twice.z_of_v, twice.z_of_load],
            [twice.v_of_z, twice.v_of_v, twice.v_of_load],
        ]
    )[:, :, 0]
    found = (step @ step)[:2]
    # In the norm of the energy, where the numbers of both rows compare.
    omega = max(math.sqrt(k[0]), 1.0)
    weights = np.array([[omega], [1.0]]) / np.array([omega, 1.0, 1.0])
    np.testing.assert_allclose(weights * found, weights * expected, rtol=1e-11, atol=1e-12 * omega)


def test_no_motion_grows_however_long_the_step() -> None:
    omega = np.logspace(-8.0, 8.0, 33)
    for alpha, beta in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1e6, 1e-9)):
        r = modal_response(omega**2, alpha + beta * omega**2, 10.0)
        # Energy norm of the transition, (ω z, v).
        matrix = np.array([[r.z_of_z, omega * r.z_of_v], [r.v_of_z / omega, r.v_of_v]])
        assert np.linalg.norm(matrix.transpose(2, 0, 1), ord=2, axis=(1, 2)).max() < 1.0 + 1e-9


@pytest.mark.parametrize("hold", ["constant", "linear"])
@pytest.mark.parametrize("kind", ["modal", "full"])
def test_one_step_is_many_small_ones_of_newmarks_method(kind: str, hold: Any) -> None:
    model, damping = linear(kind=kind), (0.4, 0.05)
    q, v, first, last = np.random.default_rng(3).normal(size=(4, 4))
    motion = ModalFilter(model, step=0.5, damping=damping, hold=hold, q=q, v=v, load=first)
    np.testing.assert_allclose(motion.q, q, rtol=1e-13)
    np.testing.assert_allclose(motion.v, v, rtol=1e-12)
    motion.advance(last)
    n = 2000
    begin = last if hold == "constant" else first
    slow = ImplicitNewmark(model, step=0.5 / n, damping=damping, q=q, v=v, load=begin)
    for i in range(n):
        slow.advance(last if hold == "constant" else first + (i + 1.0) / n * (last - first))
    np.testing.assert_allclose(motion.q, slow.q, rtol=1e-5)
    np.testing.assert_allclose(motion.v, slow.v, rtol=1e-5, atol=1e-5)
    if hold == "linear":
        np.testing.assert_allclose(motion.a, slow.a, rtol=1e-5, atol=1e-4)


def test_a_static_load_is_answered_by_its_equilibrium() -> None:
    model, load = linear(), np.array([1.0, -2.0, 0.5, 3.0])
    motion = ModalFilter(model, step=1e3, damping=(1.0, 0.0))
    motion.advance(load)
    np.testing.assert_allclose(motion.q, np.linalg.solve(model.law.linear, load), rtol=1e-12)
    np.testing.assert_allclose(motion.v, 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.a, 0.0, atol=1e-11)


@pytest.mark.parametrize("hold", ["constant", "linear"])
@pytest.mark.parametrize("kind", ["modal", "full"])
@pytest.mark.parametrize("bodies", [None, 3])
@pytest.mark.parametrize("steps", [1, 7, 300, 5000])
def test_a_run_is_its_steps(steps: int, bodies: int | None, kind: str, hold: Any) -> None:
    shape = (4,) if bodies is None else (bodies, 4)
    rng = np.random.default_rng(6)
    options: dict[str, Any] = {
        "step": 0.02,
        "damping": (0.1, 0.01),
        "hold": hold,
        "q": rng.normal(size=shape),
        "load": rng.normal(size=shape),
    }
    fast, slow = (ModalFilter(linear(kind=kind), **options) for _ in range(2))
    loads = rng.normal(size=(steps, *shape))
    found = fast.run(loads)
    expected = []
    for load in loads:
        slow.advance(load)
        expected.append(slow.q)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=1e-11 * scale, rtol=0.0)
    for name in ("q", "v", "a"):
        one, other = getattr(fast, name), getattr(slow, name)
        np.testing.assert_allclose(one, other, atol=1e-11 * np.abs(other).max(), rtol=0.0)
    assert fast.steps == slow.steps == steps
    assert fast.time == pytest.approx(0.02 * steps)
    # And both go on alike, in halves as well.
    more = rng.normal(size=(20, *shape))
    halves = np.concatenate([fast.run(more[:7]), fast.run(more[7:])])
    np.testing.assert_allclose(halves, slow.run(more), atol=1e-11 * scale)


def test_run_fills_an_array_of_the_user() -> None:
    motion = ModalFilter(linear(kind="modal"), step=0.1)
    loads, out = np.ones((10, 4)), np.empty((10, 4))
    assert motion.run(loads, out=out) is out
    np.testing.assert_array_equal(out[-1], motion.q)
    assert motion.run(np.empty((0, 4))).shape == (0, 4)
    assert motion.steps == 10
    for bad in (np.empty((9, 4)), np.empty((10, 8))[:, ::2], loads, np.empty((10, 4), np.float32)):
        with pytest.raises(LoadError, match="out must be"):
            motion.run(loads, out=bad)


def test_a_low_note_keeps_its_amplitude_and_phase() -> None:
    # 20 Hz at 44.1 kHz, ten seconds, blocks of steps and all: the recursion itself must not drift.
    omega, step, steps = 2.0 * math.pi * 20.0, 1.0 / 44100.0, 441_000
    motion = ModalFilter(oscillator(omega, is_linear=True), step=step, q=[1.0])
    found = motion.run(np.zeros((steps, 1)))[:, 0]
    times = step * np.arange(1, steps + 1)
    assert np.abs(found - np.cos(omega * times)).max() < 1e-9


def test_frequencies_and_times() -> None:
    motion = ModalFilter(oscillator(2.0 * math.pi * 5.0, is_linear=True), step=0.1)
    assert motion.frequencies == pytest.approx([5.0])
    assert motion.load_time == 0.0
    assert ModalFilter(linear(), step=0.1, hold="linear").load_time == pytest.approx(0.1)


def test_what_the_filter_cannot_take_is_refused() -> None:
    with pytest.raises(SolverError, match=r"'linear', got 'springs'; take ImplicitNewmark"):
        ModalFilter(stiffening(), step=0.1)
    wrong: Any = "cubic"
    with pytest.raises(LoadError, match="hold must be"):
        ModalFilter(linear(), step=0.1, hold=wrong)
    motion = ModalFilter(linear(), step=0.1)
    bad: list[Any] = [np.ones(3), 1.0, np.ones((2, 4))]
    for load in bad:
        with pytest.raises(LoadError, match=r"shape \(4,\)"):
            motion.advance(load)
    for load in (np.ones(4), 1.0, np.ones((2, 3))):
        with pytest.raises(LoadError, match="shape"):
            motion.run(load)


def test_what_is_not_finite_leaves_the_state_alone() -> None:
    motion = ModalFilter(linear(), step=0.1, q=np.ones(4))
    motion.run(np.ones((5, 4)))
    q, v = motion.q, motion.v
    loads = np.ones((500, 4))
    loads[300, 2] = math.nan
    with pytest.raises(DivergenceError, match=r"found at 30\.5 s.*The state at 0\.5 s stands"):
        motion.run(loads)
    with pytest.raises(DivergenceError, match=r"found at 0\.5 s"):
        motion.advance(loads[300])
    np.testing.assert_array_equal(motion.q, q)
    np.testing.assert_array_equal(motion.v, v)
    assert motion.steps == 5
    unstable = ModalFilter(Model(LinearForce(np.array([[-1e4]])), np.eye(1)), step=1.0, q=[1.0])
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(DivergenceError):
        unstable.run(np.zeros((1000, 1)))
    np.testing.assert_array_equal(unstable.q, 1.0)
