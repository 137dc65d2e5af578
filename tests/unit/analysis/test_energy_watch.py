"""Energy that comes from nothing is told, and a motion that runs away is stopped."""

import logging

import numpy as np
import pytest
from moving_bodies import LINEAR, NEO, STVK, bar, cube, lowest

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Impulse,
    Initial,
    Prescribed,
    Simulation,
    Step,
    SymplecticEuler,
    Traction,
    simulate,
    static_equilibrium,
)
from fenics_defo.errors import DivergenceError

RATE = 1.0  # rad/s


def spin(solid):
    """A rigid rotation about z."""
    arm = solid.points - solid.points.mean(axis=0)
    return Initial(velocity=RATE * np.column_stack([-arm[:, 1], arm[:, 0], np.zeros(len(arm))]))


@pytest.mark.parametrize("newton", [1, None])
@pytest.mark.parametrize("every", [0, 1])
def test_a_fast_spin_runs_away_and_is_told(newton, every):
    """Average acceleration feeds a body that turns half a radian a step."""
    solid, step = bar(STVK, held=None), 0.5 / RATE
    seen = []
    with pytest.raises(DivergenceError, match="times all the energy ever put into it") as info:
        simulate(
            solid,
            [],
            ImplicitNewmark(),
            step=step,
            duration=200 * step,
            newton=newton,
            initial=spin(solid),
            energies_every=every,
            observe=lambda simulation: seen.append((simulation.time, simulation.state)),
        )
    error, (time, state) = info.value, seen[-1]
    assert error.step == step
    assert time < error.time <= time + 1.001 * step
    for part in (f"at {error.time:.6g} s", "kinetic", "strain", "backward Euler", "smaller step"):
        assert part in str(error)
    if every:  # it was watched at each step
        mass = np.repeat(solid.lumped_mass(), 3)
        kinetic = 0.5 * mass @ state.velocity.ravel() ** 2
        assert kinetic <= 2.0 * 0.5 * mass @ spin(solid).velocity.ravel() ** 2


def test_the_state_before_a_runaway_stands():
    solid, seen = bar(STVK, held=None), []

    def go(simulation):
        for _ in range(100):
            seen.append((simulation.state, simulation.energies))
            simulation.advance()

    with Simulation(
        solid, [], ImplicitNewmark(), step=0.5 / RATE, newton=1, initial=spin(solid)
    ) as simulation:
        with pytest.raises(DivergenceError):
            go(simulation)
        state, energies = seen[-1]
        np.testing.assert_array_equal(simulation.state.displacement, state.displacement)
        assert simulation.state.step == state.step
        assert simulation.energies == energies


def test_a_drift_is_warned_of_once(caplog):
    """Some 0.05 radians a step, one iteration each: average acceleration loses half the energy."""
    solid, step = bar(STVK, held=None), 0.05 / RATE
    with caplog.at_level(logging.WARNING, "fenics_defo"):
        motion = simulate(
            solid, [], ImplicitNewmark(), step=step, duration=40 * step, initial=spin(solid)
        )
        well = simulate(
            solid,
            [],
            ImplicitNewmark(),
            step=step,
            duration=40 * step,
            newton=None,
            initial=spin(solid),
        )
    assert len([r for r in caplog.records if "energy balance" in r.getMessage()]) == 1
    balance = motion.energies.balance
    assert motion.energy_error > 0.1
    assert motion.energy_error == pytest.approx(np.abs(balance - balance[0]).max() / balance[0])
    assert well.energy_error < 0.01


def test_the_error_of_the_balance_is_that_of_the_record():
    solid = bar(STVK)
    motion = simulate(solid, [Gravity()], ImplicitNewmark(), step=0.02, duration=0.4, newton=None)
    balance, work = motion.energies.balance, motion.energies.external
    assert 0.0 < motion.energy_error < np.abs(balance - balance[0]).max() / np.abs(work).max()
    exact = simulate(bar(LINEAR), [Gravity()], ImplicitNewmark(), step=0.02, duration=0.4)
    assert exact.energy_error < 1e-12
    assert static_equilibrium(bar(LINEAR), [Gravity()]).iterations == 1


def test_losses_are_told_and_allowed():
    solid = bar(STVK)
    omega, shape = lowest(solid)
    motion = simulate(
        solid,
        [],
        BackwardEuler(),
        step=1.0 / omega,
        duration=30.0 / omega,
        newton=None,
        initial=Initial(displacement=0.05 * shape),
    )
    assert motion.energy_error > 0.99
    assert motion.energy_gain < 1e-6


ROUGH = {
    "a jump": {"prescribed": [Prescribed("x==1", (None, None, 0.05), Step(0.055))]},
    "a blow": {"loads": [Impulse(region="x==1", vector=(0.0, 0.0, 1.0), time=0.05)]},
    "a push": {"loads": [Traction("x==1", (0.0, 0.0, 300.0), Step(0.05))]},
    "nothing": {},
}


@pytest.mark.parametrize("rough", ROUGH)
@pytest.mark.parametrize(
    ("integrator", "step", "beta"),
    [
        (ImplicitNewmark(), 0.02, 0.0),
        (ImplicitNewmark(beta=0.4, gamma=0.6), 0.02, 0.1),
        (BackwardEuler(), 0.02, 0.1),
        (BackwardEuler(), 0.2, 0.0),
        (CentralDifferences(), 0.005, 0.0),
        (SymplecticEuler(), 0.005, 0.0),
    ],
)
def test_sudden_motions_are_no_runaways(rough, integrator, step, beta):
    given = {"loads": [], "prescribed": [], **ROUGH[rough]}
    motion = simulate(
        bar(STVK),
        given["loads"],
        integrator,
        step=step,
        duration=40 * step,
        damping=(0.0, beta),
        prescribed=given["prescribed"],
    )
    assert np.isfinite(motion.energy_error)


@pytest.mark.parametrize("integrator", [CentralDifferences(), SymplecticEuler()])
def test_explicit_methods_swing_freely_just_below_their_limit(integrator):
    """The highest mode at 0.98 of the limit: T + U swings by far more than itself."""
    solid = bar(LINEAR)
    omega, shape = lowest(solid, -1, lumped=True)
    motion = simulate(
        solid,
        [],
        integrator,
        step=0.98 * 2.0 / omega,
        duration=400.0 / omega,
        initial=Initial(velocity=shape),
    )
    assert motion.energy_gain > 3.0


def test_equilibria_have_no_balance():
    from_rest = static_equilibrium(cube(NEO), [Gravity()])
    assert from_rest.definite
