"""Nonlinear motion: orders of convergence, and the balance of energies with loads and damping."""

from functools import cache

import numpy as np
import pytest
from bodies import Array
from motions import EXPLICIT, INTEGRATORS, ORDERS, bar, states

from fenics_defo.analysis import (
    Gravity,
    Sine,
    simulate,
)
from fenics_defo.energy import NeoHookean, StVenantKirchhoff

each_integrator = pytest.mark.parametrize("name", INTEGRATORS)
TIME = 0.4


def smoothly(time: float) -> float:
    """From zero to one within TIME: a sudden load would move modes that no step resolves."""
    return float(np.sin(0.5 * np.pi * time / TIME) ** 2)


WEIGHT = Gravity((0.0, 0.0, -6.0), history=smoothly)


@cache
def swung(name: str, count: int, newton: int | None) -> Array:
    """Displacement and velocity (2, 3) of the tip of a bar whose weight comes on, after some TIME.

    From rest and without a force the displacements of symplectic Euler are those of central
    differences; its velocities are of first order.
    """
    solid = bar(StVenantKirchhoff)
    found = states(
        solid,
        INTEGRATORS[name],
        step=TIME / count,
        count=count,
        loads=[WEIGHT],
        newton=newton,
        newton_tolerance=1e-10,
    )
    end = solid.points[:, 0] > 1.0 - 1e-9
    last = found[-1]
    return np.array([last.displacement[end].mean(axis=0), last.velocity[end].mean(axis=0)])


@pytest.mark.parametrize(
    ("name", "newton"),
    [*((name, None) for name in INTEGRATORS), ("newmark", 1), ("backward-euler", 1)],
)
def test_order_of_convergence(name: str, newton: int | None) -> None:
    """By Richardson's ratio; one Newton iteration a step does not cost the order."""
    counts = (80, 160, 320) if name in EXPLICIT else (20, 40, 80)
    coarse, middle, fine = (swung(name, count, newton) for count in counts)
    assert np.abs(fine[0, 2]) > 0.1
    observed = np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    assert observed == pytest.approx(ORDERS[name], abs=0.3)


def test_all_methods_tend_to_the_same_motion() -> None:
    """Consistent or lumped mass apart: implicit with implicit, explicit with explicit."""
    newmark = swung("newmark", 80, None)
    euler = 2.0 * swung("backward-euler", 80, None) - swung("backward-euler", 40, None)
    assert euler == pytest.approx(newmark, abs=0.02 * np.abs(newmark).max())
    central = swung("central-differences", 320, None)
    symplectic = 2.0 * swung("symplectic-euler", 320, None) - swung("symplectic-euler", 160, None)
    assert symplectic == pytest.approx(central, abs=1e-3 * np.abs(central).max())
    assert central == pytest.approx(newmark, abs=0.1 * np.abs(newmark).max())


@each_integrator
def test_energies_balance(name: str) -> None:
    """kinetic + strain + dissipated - external is constant, but for the order of the method."""
    errors = []
    for count in (60, 120):
        motion = simulate(
            bar(NeoHookean),
            [Gravity((0.0, 0.0, -1.5), history=Sine(1.2))],
            INTEGRATORS[name],
            step=TIME / count,
            duration=TIME,
            damping=(0.6, 0.004),
            newton=None,
        )
        size = np.abs(motion.energies.external).max()
        assert motion.energies.dissipated[-1] > 0.05 * size
        assert (np.diff(motion.energies.dissipated) > -1e-12 * size).all()
        errors.append(np.abs(motion.energies.balance - motion.energies.balance[0]).max() / size)
    assert errors[1] < 0.05
    # The explicit methods take the velocity of stiffness damping from half a step before.
    order = 1.0 if name in EXPLICIT else ORDERS[name]
    assert np.log2(errors[0] / errors[1]) > 0.75 * order
