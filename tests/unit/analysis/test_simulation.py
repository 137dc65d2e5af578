"""Simulations step by step: failures, limits, impulses, restarts."""

import math

import numpy as np
import pytest
from moving_bodies import LINEAR, NEO, STVK, TIP, bar, cube, lowest

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Impulse,
    Initial,
    PointLoad,
    Prescribed,
    Pressure,
    Pulse,
    QuasiStatic,
    Ramp,
    Simulation,
    Sine,
    SymplecticEuler,
    Traction,
    simulate,
)
from fenics_defo.analysis.instant import Instant, StepFailure
from fenics_defo.analysis.substeps import run_substeps
from fenics_defo.errors import DivergenceError, LoadError, SolverError, StepSizeError
from fenics_defo.fem.linear_solvers import Cholesky

EXPLICIT = [CentralDifferences(), SymplecticEuler()]
ALL = [ImplicitNewmark(), BackwardEuler(), *EXPLICIT]
IDS = ["newmark", "backward", "central", "symplectic"]
NOTHING = np.zeros((0, 3))


def run(simulation, steps):
    for _ in range(steps):
        simulation.advance()


def at(time):
    return Instant(time, NOTHING, NOTHING, NOTHING)


def walk(longest, *, most=3, end=8.0):
    """Steps kept on the way from 0 to ``end`` where only those up to ``longest(time)`` succeed."""
    kept = []

    def advance(start, length):
        if length > longest(start.time):
            raise StepFailure("too long", (1.0, 2.0))
        return at(start.time + length)

    halvings = run_substeps(
        at(0.0),
        end,
        advance=advance,
        keep=lambda start, reached: kept.append((start.time, reached.time)),
        most=most,
    )
    return kept, halvings


def test_a_failed_step_is_halved_and_grows_again():
    assert walk(lambda time: 8.0) == ([(0.0, 8.0)], 0)
    assert walk(lambda time: 2.0 if time < 4.0 else 8.0) == (
        [(0.0, 2.0), (2.0, 4.0), (4.0, 8.0)],
        2,
    )
    limits = {0.0: 4.0, 4.0: 2.0, 6.0: 1.0, 7.0: 1.0}
    assert walk(limits.__getitem__) == ([(0.0, 4.0), (4.0, 6.0), (6.0, 7.0), (7.0, 8.0)], 3)


def test_the_limit_of_halvings_is_kept_and_told():
    with pytest.raises(DivergenceError, match=r"too long; relative residuals 1\.0e\+00, 2") as info:
        walk(lambda time: 2.0 if time < 2.0 else 0.5)
    assert info.value.time == 2.0
    assert info.value.step == 1.0
    assert info.value.residuals == (1.0, 2.0)


def test_a_step_that_newton_cannot_do_is_done_in_halves():
    solid = cube(NEO)
    options = {"newton": None, "newton_tolerance": 1e-9, "newton_iterations": 1}
    motion = simulate(
        solid,
        [],
        ImplicitNewmark(),
        step=0.2,
        duration=0.2,
        prescribed=[Prescribed("z==1", (0.0, 0.0, -0.5), history=Ramp(0.2))],
        **options,
    )
    (report,) = motion.reports
    assert report.halvings >= 1
    assert len(report.substeps) > 1
    assert report.time == 0.2
    assert all(substep.residuals[-1] <= 1e-9 for substep in report.substeps)
    top = solid.points[:, 2] == 1.0
    assert motion.state.displacement[top] == pytest.approx(
        np.broadcast_to((0.0, 0.0, -0.5), (9, 3)), abs=1e-14
    )


def test_divergence_tells_all_and_leaves_the_last_good_state():
    crush = [Prescribed("z==1", (0.0, 0.0, -0.5), history=Ramp(0.2, start=0.2))]
    with Simulation(
        cube(NEO),
        [Gravity()],
        ImplicitNewmark(),
        step=0.1,
        newton=None,
        newton_tolerance=1e-13,
        newton_iterations=1,
        prescribed=crush,
        max_halvings=1,
    ) as simulation:
        with pytest.raises(DivergenceError) as info:
            run(simulation, 4)
        assert simulation.time == info.value.time
        state = simulation.state
    assert np.isfinite(state.displacement).all()
    text = str(info.value)
    for part in ("no step of 0.1 s", f"at {info.value.time:.6g} s", "0.05 s", "in 3 iterations"):
        assert part in text
    assert "relative residuals" in text
    assert "try a smaller step" in text
    assert info.value.residuals


@pytest.mark.parametrize("integrator", EXPLICIT, ids=IDS[2:])
@pytest.mark.parametrize("damping", [(0.0, 0.0), (0.0, 2e-3)])
def test_explicit_methods_are_stable_just_below_their_limit_only(integrator, damping):
    """The limit is that of the largest frequency of the lumped body by SciPy."""
    solid = bar(LINEAR)
    number = int((~solid.held).sum()) - 1
    omega, shape = lowest(solid, number, lumped=True)
    ratio = damping[1] * omega / 2.0
    limit = 2.0 / omega * (math.sqrt(1.0 + ratio**2) - ratio)
    start = Initial(displacement=1e-6 * shape)
    growth = {}
    for part in (0.998, 1.003):
        with Simulation(
            solid,
            [],
            integrator,
            step=part * limit,
            damping=damping,
            initial=start,
            allow_unstable=True,
        ) as simulation:
            assert simulation.critical_step == pytest.approx(limit, rel=1e-4)
            run(simulation, 600)
            growth[part] = np.abs(simulation.state.displacement).max() / 1e-6
    assert growth[0.998] < 20.0
    assert growth[1.003] > 1e6
    with pytest.raises(StepSizeError, match=rf"beyond .* of {type(integrator).__name__} at 0 s"):
        Simulation(solid, [], integrator, step=1.003 * limit, damping=damping)


def test_implicit_methods_have_no_limit():
    with Simulation(bar(LINEAR), [], BackwardEuler(), step=1e3) as simulation:
        assert simulation.critical_step == math.inf


def test_no_number_is_lost_when_a_motion_explodes():
    """Beyond the limit the energies grow until a number overflows: never NaN in a state."""
    with Simulation(
        cube(STVK),
        [Gravity()],
        CentralDifferences(),
        step=0.5,
        max_halvings=1,
        allow_unstable=True,
    ) as simulation:
        with pytest.raises(DivergenceError, match="infinite or no number"):
            run(simulation, 300)
        state = simulation.state
        assert np.isfinite(simulation.energies.external)
    assert np.isfinite(state.displacement).all()
    assert np.isfinite(state.velocity).all()


def test_a_stiffening_body_meets_the_limit_later():
    """Stretched, St. Venant-Kirchhoff stiffens: the limit is looked at again on the way."""
    solid = cube(STVK)
    pull = [Prescribed("z==1", (0.0, 0.0, 3.0), history=Ramp(0.1))]
    with Simulation(solid, [], CentralDifferences(), step=1e-9, prescribed=pull) as simulation:
        limit = simulation.critical_step
    with (
        Simulation(
            solid, [], CentralDifferences(), step=0.5 * limit, prescribed=pull
        ) as simulation,
        pytest.raises(StepSizeError, match="largest stable step"),
    ):
        run(simulation, 600)


@pytest.mark.parametrize("integrator", ALL, ids=IDS)
def test_an_impulse_changes_the_momentum_by_itself(integrator):
    solid = bar(STVK, held=None)
    blows = [
        Impulse(point=(0.6, 0.1, 0.2), vector=(0.2, 0.0, 1.0), time=0.0),
        Impulse(region="x>0.6", vector=(0.0, 3.0, 0.0), time=0.0101),
        Impulse(node=3, vector=(0.0, 0.0, -1.0), time=0.03),
    ]
    momenta = []
    simulate(
        solid,
        blows,
        integrator,
        step=5e-3,
        duration=0.02,
        newton=None,
        newton_tolerance=1e-12,
        observe=lambda simulation: momenta.append(simulation.momentum()[0]),
    )
    momenta = np.array(momenta)
    expected = np.array([(0, 0, 0), (0.2, 0, 1), (0.2, 0, 1), (0.2, 3, 1), (0.2, 3, 1)])
    assert momenta == pytest.approx(expected, abs=1e-10)


def test_an_impulse_does_the_work_that_the_motion_takes():
    """p²/2M in a body that is struck in proportion to its mass."""
    solid = bar(LINEAR, held=None)
    for integrator in (ImplicitNewmark(), CentralDifferences()):
        blow = Impulse(region="x>-1", vector=(6.0, 0.0, 8.0))
        motion = simulate(solid, [blow], integrator, step=1e-3, duration=2e-3, damping=(0.0, 1e-4))
        assert motion.energies.external[-1] == pytest.approx(100.0 / 2.0 / 60.0, rel=1e-3)
        assert motion.energies.balance == pytest.approx(0.0, abs=1e-6)


LOADS = [
    Gravity((0.0, 0.0, -5.0), history=Sine(2.0)),
    Pressure("x==1", 300.0, history=Pulse(0.01, 0.02)),
    Traction("z==0.2", (0.0, 20.0, 0.0), history=Ramp(0.05)),
    PointLoad(point=TIP, vector=(1.0, 0.0, 0.0)),
    Impulse(region="x>0.6", vector=(0.0, 0.5, 0.0), time=0.026),
]


@pytest.mark.parametrize("integrator", ALL, ids=IDS)
def test_a_restart_goes_on_to_the_same_bits(integrator):
    solid = bar(STVK, held=None)
    options = {
        "step": 4e-3,
        "damping": (0.1, 1e-4),
        "prescribed": [Prescribed("x==0", (None, 0.0, 0.05), history=Sine(3.0))],
        "newton": None if integrator == ALL[0] else 1,
    }
    with Simulation(solid, LOADS, integrator, **options) as simulation:
        run(simulation, 4)
        state, energies = simulation.state, simulation.energies
        run(simulation, 6)
        whole, whole_energies = simulation.state, simulation.energies
    with Simulation(solid, LOADS, integrator, **options) as simulation:
        simulation.restore(state, energies)
        assert (simulation.steps, simulation.time) == (4, state.time)
        assert simulation.energies == energies
        run(simulation, 6)
        again, again_energies = simulation.state, simulation.energies
    assert again.time == whole.time == 0.04
    assert again.step == whole.step == 10
    for name in ("displacement", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(again, name), getattr(whole, name))
    assert again_energies == whole_energies


def test_a_state_of_another_body_is_refused():
    with Simulation(bar(LINEAR), [], BackwardEuler(), step=0.1) as simulation:
        state, energies = simulation.state, simulation.energies
    with (
        Simulation(cube(NEO), [], BackwardEuler(), step=0.1) as simulation,
        pytest.raises(LoadError, match="the displacement of a state of this body"),
    ):
        simulation.restore(state, energies)


def test_semi_implicit_steps_solve_once_and_say_what_they_left():
    loads = [Gravity((0.0, 0.0, -2.0))]
    motion = simulate(bar(STVK), loads, ImplicitNewmark(), step=0.05, duration=0.25)
    assert [report.newton_iterations for report in motion.reports] == [1] * 5
    assert all(len(report.residuals) == 2 for report in motion.reports)
    assert 1e-6 < motion.reports[-1].residuals[-1] < 0.5


@pytest.mark.parametrize("linear", ["pcg-jacobi", "pcg-amg"])
def test_iterative_solvers_give_the_motion_of_the_direct_one(linear):
    loads = [Gravity((0.0, 1.0, -9.81))]
    tips = [
        simulate(
            bar(STVK),
            loads,
            ImplicitNewmark(),
            step=0.02,
            duration=0.1,
            linear=kind,
            linear_tolerance=1e-11,
            probes={"tip": TIP},
        ).probes["tip"][-1]
        for kind in ("cholesky", linear)
    ]
    assert tips[1] == pytest.approx(tips[0], rel=1e-8)


def test_the_start_is_reported_too():
    seen = []
    motion = simulate(
        bar(LINEAR),
        [],
        ImplicitNewmark(),
        step=0.1,
        duration=0.31,
        energies_every=2,
        probes={"tip": TIP},
        observe=lambda simulation: seen.append((simulation.steps, simulation.time)),
    )
    assert [step for step, _ in seen] == [0, 1, 2, 3]
    assert motion.times == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert motion.energies.times == pytest.approx([0.0, 0.2])
    assert motion.probes["tip"].shape == (4, 3)


def test_quasi_static_motion_passes_through_equilibria():
    """Linear body: displacements in proportion to the load, whatever the step."""
    load = Gravity((0.0, 0.0, -1.0), history=Ramp(1.0))
    options = {"newton": None, "newton_tolerance": 1e-9, "probes": {"tip": TIP}}
    motion = simulate(bar(LINEAR), [load], QuasiStatic(), step=0.25, duration=1.0, **options)
    tips = motion.probes["tip"]
    for number in range(5):
        assert tips[number] == pytest.approx(tips[4] * motion.times[number], rel=1e-8, abs=1e-12)
    assert motion.energies.balance == pytest.approx(0.0, abs=1e-9 * motion.energies.strain[-1])
    assert motion.energies.kinetic == pytest.approx(0.0, abs=0.0)
    with pytest.raises(SolverError, match="6 rigid motions"):
        Simulation(bar(LINEAR, held=None), [load], QuasiStatic(), step=0.1)


def test_durations_and_steps_that_make_no_sense_are_refused():
    for step, duration in ((0.1, 0.0), (0.1, math.nan), (1.0, 0.3), (-1.0, 1.0), (0.0, 1.0)):
        with pytest.raises(StepSizeError):
            simulate(bar(LINEAR), [], BackwardEuler(), step=step, duration=duration)


@pytest.mark.parametrize(("material", "times"), [(LINEAR, 1), (STVK, 4)])
def test_a_linear_body_is_factorised_once(monkeypatch, material, times):
    prepared = []
    honest = Cholesky.prepare
    monkeypatch.setattr(
        Cholesky, "prepare", lambda self, matrix: prepared.append(honest(self, matrix))
    )
    with Simulation(bar(material), [Gravity()], ImplicitNewmark(), step=1e-3) as simulation:
        run(simulation, 4)
    assert len(prepared) == times
