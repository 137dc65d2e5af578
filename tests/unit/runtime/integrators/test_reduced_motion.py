"""What theory says of the integrators on reduced models."""

import math
import tracemalloc
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from reduced_models import Model, Springs, linear, oscillator, stiffening

from fenics_defo.errors import DefoError, DivergenceError, LoadError, SolverError, StepSizeError
from fenics_defo.runtime import ReducedModel
from fenics_defo.runtime.forces import CubicForce
from fenics_defo.runtime.forces.symmetric import unique_count
from fenics_defo.runtime.integrators import (
    BackwardEuler,
    CentralDifferences,
    ImplicitNewmark,
    SymplecticEuler,
    dense_solver,
    newton_step,
)
from fenics_defo.runtime.integrators.limits import leapfrog_limit

Array = NDArray[np.float64]
ALL: list[Any] = [ImplicitNewmark, BackwardEuler, CentralDifferences, SymplecticEuler]
EXPLICIT: list[Any] = [CentralDifferences, SymplecticEuler]
DUFFING = oscillator(3.0, fourth=54.0)


def end(make: Any, step: float, **options: Any) -> float:
    """Position of Duffing's oscillator q'' + 9 q + 9 q³ = 2 sin 2t at t = 1."""
    motion = make(DUFFING, step=step, q=[0.7], **options)
    for _ in range(round(1.0 / step)):
        motion.advance(np.array([2.0 * math.sin(2.0 * motion.load_time)]))
    return float(motion.q[0])


@pytest.mark.parametrize(
    ("make", "order", "options"),
    [
        (ImplicitNewmark, 2, {}),
        (ImplicitNewmark, 2, {"newton": 3}),
        (ImplicitNewmark, 2, {"newton": None, "newton_tolerance": 1e-12}),
        (ImplicitNewmark, 2, {"damping": (0.3, 0.0), "newton": 2}),
        (ImplicitNewmark, 1, {"damping": (0.3, 0.02)}),  # K of the start of the step
        (ImplicitNewmark, 2, {"damping": (0.3, 0.02), "newton": 2}),
        (ImplicitNewmark, 1, {"beta": 0.4, "gamma": 0.8}),
        (BackwardEuler, 1, {}),
        (CentralDifferences, 2, {"damping": (0.4, 0.0)}),
        (CentralDifferences, 1, {"damping": (0.0, 0.05)}),
        (SymplecticEuler, 1, {"damping": (0.3, 0.02)}),
    ],
)
def test_the_order_of_convergence(make: Any, order: int, options: dict[str, Any]) -> None:
    # Differences of runs with halved steps fall by two to the order.
    positions = [end(make, 1.0 / n, **options) for n in (100, 200, 400)]
    ratio = (positions[0] - positions[1]) / (positions[1] - positions[2])
    assert math.log2(ratio) == pytest.approx(order, abs=0.15)


def test_all_methods_go_to_the_same_motion() -> None:
    reference = end(ImplicitNewmark, 1.0 / 1000)
    for make in ALL:
        assert end(make, 1.0 / 1000) == pytest.approx(reference, abs=4e-3)


@pytest.mark.parametrize("kind", ["modal", "full"])
def test_average_acceleration_keeps_the_energy_of_linear_models(kind: str) -> None:
    model = linear(kind=kind)
    motion = ImplicitNewmark(model, step=0.2, q=np.ones(4), v=np.arange(4.0), energies=True)
    start = motion.energies
    for _ in range(300):
        motion.advance()
    now = motion.energies
    assert now.kinetic + now.strain == pytest.approx(start.kinetic + start.strain, rel=1e-12)
    assert now.kinetic != pytest.approx(start.kinetic, rel=1e-3)
    assert now.external == now.dissipated == 0.0


def test_energies_of_linear_models_balance_with_loads_and_damping() -> None:
    model = linear()
    motion = ImplicitNewmark(
        model, step=0.1, q=np.ones(4), load=np.ones(4), damping=(0.3, 0.02), energies=True
    )
    start = motion.energies.balance
    for number in range(100):
        motion.advance(np.cos(0.3 * number + np.arange(4.0)))
        if number == 50:
            motion.kick(np.array([1.0, -2.0, 0.5, 0.0]), load=np.cos(0.3 * number + np.arange(4.0)))
    energies = motion.energies
    assert energies.dissipated > 1.0
    assert energies.balance == pytest.approx(start, rel=1e-11)


@pytest.mark.parametrize("make", ALL)
def test_the_balance_of_a_nonlinear_body_is_off_by_the_order_of_the_method(make: Any) -> None:
    errors = []
    # In central differences the lag of the stiffness damping cancels much of the other error.
    damping = (0.2, 0.0 if make is CentralDifferences else 0.01)
    for n in (100, 200):
        motion = make(DUFFING, step=1.0 / n, q=[0.8], damping=damping, energies=True)
        start = motion.energies.balance
        off = 0.0
        for _ in range(n):
            motion.advance(np.array([1.0]))
            off = max(off, abs(motion.energies.balance - start))
        errors.append(off)
    assert errors[1] < 0.62 * errors[0]
    assert errors[1] < 0.1 * start


def test_work_of_a_constant_load_is_force_times_way() -> None:
    for make in ALL:
        motion = make(DUFFING, step=0.01, load=[2.0], energies=True)
        for _ in range(40):
            motion.advance(np.array([2.0]))
        expected = motion.energies.external
        assert expected == pytest.approx(2.0 * motion.q[0], rel=1e-12)


def test_energies_must_be_asked_for() -> None:
    motion = ImplicitNewmark(DUFFING, step=0.01)
    with pytest.raises(DefoError, match="energies=True"):
        _ = motion.energies


@pytest.mark.parametrize("kind", ["modal", "full"])
@pytest.mark.parametrize("make", [ImplicitNewmark, BackwardEuler])
def test_implicit_methods_stand_huge_steps(make: Any, kind: str) -> None:
    motion = make(linear(kind=kind), step=1e6, q=np.ones(4), v=np.ones(4))
    for _ in range(50):
        motion.advance(np.zeros(4))
    # Newmark's method keeps the energy, of which v of 1 is a little; Euler's takes it away.
    largest = np.abs(motion.q).max()
    assert largest < (20.0 if make is ImplicitNewmark else 1e-6)


def test_backward_euler_reaches_the_equilibrium_of_a_nonlinear_body() -> None:
    model, load = stiffening(), np.array([5.0, -3.0, 2.0, 1.0])
    motion = BackwardEuler(model, step=10.0, newton=8)
    for _ in range(30):
        motion.advance(load)
    np.testing.assert_allclose(model.law.force(motion.q), load, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("beta", [0.0, 0.01])
@pytest.mark.parametrize("make", EXPLICIT)
def test_the_critical_step_is_sharp(make: Any, beta: float) -> None:
    model = linear()
    squares = np.linalg.eigvals(np.linalg.solve(model.mass, model.law.linear)).real
    limit = leapfrog_limit(math.sqrt(squares.max()), beta)
    largest = {}
    for part in (0.999, 1.001):
        motion = make(
            model, step=part * limit, damping=(0.0, beta), q=np.ones(4), allow_unstable=True
        )
        assert motion.critical_step == pytest.approx(limit, rel=1e-10)
        for _ in range(2000):
            motion.advance()
        largest[part] = np.abs(motion.q).max()
    assert largest[0.999] < 100.0 < 1e6 < largest[1.001]


@pytest.mark.parametrize("make", EXPLICIT)
def test_explicit_methods_refuse_larger_steps(make: Any) -> None:
    assert make(oscillator(10.0), step=0.199).critical_step == pytest.approx(0.2)
    with pytest.raises(StepSizeError, match=r"0\.201 s is beyond 0\.2 s.*allow_unstable=True"):
        make(oscillator(10.0), step=0.201)
    # Where the motion begins, a hardening body is stiffer than at rest: K = 9 + 27 q².
    with pytest.raises(StepSizeError, match="beyond"):
        make(DUFFING, step=0.5, q=[[0.0], [1.0]])
    make(DUFFING, step=0.5, q=[[0.0], [0.1]])


@pytest.mark.parametrize("make", EXPLICIT)
def test_a_model_without_stiffness_has_no_critical_step(make: Any) -> None:
    assert make(oscillator(0.0), step=1e9).critical_step == math.inf


def until_it_fails(motion: Any) -> tuple[DivergenceError, tuple[Any, ...]]:
    """The error, and the state before the step that failed."""
    for _ in range(1000):
        before = motion.q, motion.v, motion.a, motion.time, motion.steps
        try:
            motion.advance()
        except DivergenceError as error:
            return error, before
    raise AssertionError("it never failed")


@pytest.mark.parametrize("warnings", ["raise", "ignore"])
@pytest.mark.parametrize("bodies", [None, 3])
@pytest.mark.parametrize("make", ALL)
def test_divergence_keeps_the_last_good_state(make: Any, bodies: int | None, warnings: Any) -> None:
    # So fast that its force is soon beyond the largest number.
    v = np.array([1e120]) if bodies is None else np.array([[0.0], [1e120], [0.1]])
    motion = make(DUFFING, step=0.1, v=v)
    with np.errstate(over=warnings, invalid=warnings):
        error, before = until_it_fails(motion)
    for now, then in zip((motion.q, motion.v, motion.a), before[:3], strict=True):
        np.testing.assert_array_equal(now, then)
        assert np.isfinite(now).all()
    assert (motion.time, motion.steps) == before[3:]
    assert (error.time, error.step) == (motion.time, 0.1)
    assert "The state at that time stands; try a smaller step" in str(error)
    assert bodies is None or "bodies 1 of 3" in str(error)
    # And it can go on from somewhere else.
    motion.restart(np.array([0.01]), time=5.0)
    motion.advance()
    assert motion.time == pytest.approx(5.1)


@pytest.mark.parametrize("newton", [1, 2, None])
def test_a_singular_matrix_is_a_divergence(newton: int | None) -> None:
    # K + 4/h² = 0 at rest.
    model = Model(Springs(np.array([[-256.0]]), np.eye(1)), np.eye(1))
    motion = ImplicitNewmark(model, step=0.125, newton=newton)
    with pytest.raises(DivergenceError, match=r"no step of 0\.125 s was found at 0 s"):
        motion.advance(np.ones(1))
    np.testing.assert_array_equal(motion.q, 0.0)


@pytest.mark.parametrize("make", ALL)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_load_that_is_not_finite_is_told(make: Any, bad: float) -> None:
    for model in (stiffening(), linear(kind="modal")):
        motion = make(model, step=0.01)
        motion.advance(np.ones(4))
        q = motion.q
        with pytest.raises(DivergenceError, match="the load is not finite"):
            motion.advance(np.array([1.0, bad, 0.0, 0.0]))
        np.testing.assert_array_equal(motion.q, q)
        motion.advance(np.ones(4))
        assert np.isfinite(motion.q).all()


@pytest.mark.parametrize("make", ALL)
@pytest.mark.parametrize("bodies", [None, 64])
def test_a_step_allocates_nothing_that_grows_with_the_model(make: Any, bodies: int | None) -> None:
    r = 30
    rng = np.random.default_rng(0)
    law = CubicForce.from_unique(
        np.diag(np.linspace(10.0, 1000.0, r)),
        rng.normal(size=unique_count(r, 3)),
        rng.uniform(size=unique_count(r, 4)),
    )
    motion = make(Model(law, np.eye(r)), step=1e-3, damping=(0.1, 0.0), batch=bodies)
    load = np.ones((r,) if bodies is None else (bodies, r))
    for _ in range(5):
        motion.advance(load)
    tracemalloc.start()
    try:
        for _ in range(20):
            motion.advance(load)
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(50):
            motion.advance(load)
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # LAPACK's own copy of one matrix; for batches, NumPy's 64 KiB for broadcasting, and what the
    # evaluator makes of the size of q. Copies of all matrices would be 460 kB.
    allowed = 8 * r * (r + 3) + 1500
    if bodies is not None:
        allowed += 2**16 + 2 * load.nbytes
    assert peak - before < allowed
    assert after - before < 500


def test_a_kick_changes_the_momentum() -> None:
    model, momentum = stiffening(), np.array([1.0, -2.0, 3.0, 0.5])
    motion = ImplicitNewmark(model, step=0.01, energies=True)
    motion.kick(momentum)
    np.testing.assert_allclose(model.mass @ motion.v, momentum, rtol=1e-12)
    assert motion.energies.external == pytest.approx(motion.energies.kinetic, rel=1e-12)
    np.testing.assert_array_equal(motion.a, 0.0)
    with pytest.raises(LoadError, match="finite"):
        motion.kick([math.nan, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("make", ALL)
def test_a_kicked_damped_body_feels_its_damping_at_once(make: Any) -> None:
    model, damping = stiffening(), (0.5, 0.02)
    motion = make(model, step=0.01, q=0.1 * np.ones(4), damping=damping)
    load = np.arange(4.0)
    motion.kick(np.ones(4), load=load)
    c = damping[0] * model.mass + damping[1] * model.law.stiffness(motion.q)
    balance = model.mass @ motion.a + c @ motion.v + model.law.force(motion.q)
    np.testing.assert_allclose(balance, load, atol=1e-12)


@pytest.mark.parametrize("make", ALL)
def test_a_restart_repeats_the_motion(make: Any) -> None:
    motion = make(stiffening(), step=0.01, v=np.ones(4), load=np.ones(4))
    first = []
    for _ in range(5):
        motion.advance(np.ones(4))
        first.append(motion.q)
    motion.restart(v=np.ones(4), load=np.ones(4), time=3.0)
    for expected in first:
        motion.advance(np.ones(4))
        np.testing.assert_array_equal(motion.q, expected)
    assert motion.time == pytest.approx(3.05)
    assert motion.steps == 5


def test_states_are_copies() -> None:
    motion = ImplicitNewmark(stiffening(), step=0.01, v=np.ones(4))
    held = motion.q
    held[:] = 7.0
    motion.advance()
    assert np.abs(motion.q).max() < 1.0


def test_converged_newton_meets_its_tolerance_where_one_iteration_does_not() -> None:
    model, step, load = stiffening(), 0.3, np.array([40.0, -30.0, 20.0, 10.0])
    ratios = {}
    for newton in (1, None):
        motion = ImplicitNewmark(model, step=step, newton=newton, newton_tolerance=1e-9)
        motion.advance(load)
        terms = model.mass @ motion.a, model.law.force(motion.q), load
        residual = terms[0] + terms[1] - load
        ratios[newton] = np.linalg.norm(residual) / max(map(np.linalg.norm, terms))
    assert ratios[None] <= 1e-9 < 1e-2 < ratios[1]


def test_a_search_finds_steps_that_full_newton_does_not() -> None:
    # A step so long that it is an equilibrium of a spring, which one blow throws far beyond.
    model = oscillator(1.0, fourth=6e6)
    load = np.array([1e6])
    motion = BackwardEuler(model, step=1e3, newton=None, newton_tolerance=1e-10)
    motion.advance(load)
    np.testing.assert_allclose(model.law.force(motion.q), load, rtol=1e-6)
    batch = BackwardEuler(model, step=1e3, newton=None, newton_tolerance=1e-10, batch=2)
    batch.advance(np.array([[0.0], [1e6]]))
    np.testing.assert_array_equal(batch.q[0], 0.0)
    np.testing.assert_allclose(batch.q[1], motion.q, rtol=1e-9)


def test_newton_that_does_not_converge_in_time_is_a_divergence() -> None:
    motion = ImplicitNewmark(
        stiffening(), step=1.0, newton=None, newton_iterations=1, newton_tolerance=1e-12
    )
    with pytest.raises(DivergenceError):
        motion.advance(np.full(4, 100.0))


def test_the_bare_solver_is_the_public_one() -> None:
    rng = np.random.default_rng(0)
    for shape in ((5,), (3, 5)):
        matrix, right_side = rng.normal(size=(*shape, 5)), rng.normal(size=shape)
        found, public = np.empty(shape), np.empty(shape)
        dense_solver.solve(matrix, right_side, found)
        dense_solver._public(matrix, right_side, public)
        np.testing.assert_array_equal(found, public)


@pytest.mark.parametrize("bodies", [None, 2])
def test_the_public_solver_serves_as_well(
    bodies: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    options: dict[str, Any] = {"step": 0.125, "batch": bodies}
    bare = ImplicitNewmark(stiffening(), v=np.ones(4), **options)
    monkeypatch.setattr(newton_step, "solve", dense_solver._public)
    public = ImplicitNewmark(stiffening(), v=np.ones(4), **options)
    for motion in (bare, public):
        motion.advance()
    np.testing.assert_array_equal(bare.q, public.q)
    # K + 4/h² = 0 raises in it.
    motion = ImplicitNewmark(Model(Springs(np.array([[-256.0]]), np.eye(1)), np.eye(1)), **options)
    with pytest.raises(DivergenceError):
        motion.advance()
    np.testing.assert_array_equal(motion.q, 0.0)


GOOD: dict[str, Any] = {"step": 0.01}


@pytest.mark.parametrize(
    ("error", "match", "options"),
    [
        (StepSizeError, "positive and finite", {"step": 0.0}),
        (StepSizeError, "positive and finite", {"step": math.nan}),
        (LoadError, "two numbers from 0", {"damping": (-1.0, 0.0)}),
        (LoadError, "two numbers from 0", {"damping": 0.1}),
        (LoadError, r"\(4,\)", {"q": np.ones(3)}),
        (LoadError, "not finite", {"v": [0.0, math.inf, 0.0, 0.0]}),
        (LoadError, "a number of bodies", {"batch": 0}),
        (LoadError, r"\(2, 4\)", {"q": np.ones((2, 4)), "v": np.ones((3, 4))}),
        (SolverError, "whole number", {"newton": 0}),
        (SolverError, "whole number", {"newton": 1.5}),
        (SolverError, "between 0 and 1", {"newton": None, "newton_tolerance": 0.0}),
        (SolverError, "whole number", {"newton": None, "newton_iterations": 0}),
        (LoadError, "2 beta >= gamma", {"beta": 0.2}),
        (LoadError, "gamma >= 0.5", {"gamma": math.nan}),
    ],
)
def test_what_cannot_be_is_refused(
    error: type[DefoError], match: str, options: dict[str, Any]
) -> None:
    with pytest.raises(error, match=match):
        ImplicitNewmark(stiffening(), **(GOOD | options))


@pytest.mark.parametrize(
    "load", [np.ones(3), np.ones((4, 1)), 1.0, np.ones((2, 4))], ids=["3", "4x1", "0", "2x4"]
)
def test_loads_of_another_shape_are_refused(load: Any) -> None:
    motion = ImplicitNewmark(stiffening(), **GOOD)
    with pytest.raises(LoadError, match=r"shape \(4,\)"):
        motion.advance(load)


def test_a_mass_that_is_no_mass_is_refused() -> None:
    law = stiffening().law
    for mass in (np.diag([1.0, 1.0, 1.0, 0.0]), np.triu(np.ones((4, 4))), np.full((4, 4), np.nan)):
        with pytest.raises(SolverError, match="positive definite"):
            ImplicitNewmark(Model(law, mass), step=0.1)


def test_a_reduced_model_is_what_the_integrators_ask_for() -> None:
    plain = linear()
    model = ReducedModel(law=plain.law, mass=plain.mass, damping=(0.1, 0.02))
    one = ImplicitNewmark(model, step=0.1, v=np.ones(4), energies=True)
    two = ImplicitNewmark(plain, step=0.1, v=np.ones(4), damping=(0.1, 0.02), energies=True)
    for motion in (one, two):
        motion.advance()
    np.testing.assert_array_equal(one.q, two.q)
    assert one.energies == two.energies


def test_damping_is_the_models_own_unless_given() -> None:
    model = Model(stiffening().law, np.eye(4), (0.3, 0.02))
    one = ImplicitNewmark(model, step=0.1, v=np.ones(4))
    two = ImplicitNewmark(stiffening(unit_mass=True), step=0.1, v=np.ones(4), damping=(0.3, 0.02))
    none = ImplicitNewmark(model, step=0.1, v=np.ones(4), damping=(0.0, 0.0))
    for motion in (one, two, none):
        motion.advance()
    np.testing.assert_array_equal(one.q, two.q)
    assert np.abs(one.q - none.q).max() > 1e-3
