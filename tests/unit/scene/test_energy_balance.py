"""A played motion that gains energy from nothing is refused."""

import numpy as np
import pytest

from fenics_defo.analysis.states import Energies
from fenics_defo.errors import DivergenceError
from fenics_defo.scene.energy_balance import EnergyBalance


def test_a_balanced_motion_passes() -> None:
    """A spring, with damping, under a constant pull: T + U + D = W."""
    balance = EnergyBalance(Energies(0.0, 0.0, 0.0, 0.0), step=0.1)
    for work in np.linspace(0.0, 5.0, 20):
        balance.judge(Energies(0.5 * work, 0.3 * work, work, 0.2 * work), 1.0)
    assert balance.error == pytest.approx(0.0, abs=1e-15)


def test_losses_are_told_and_not_judged() -> None:
    balance = EnergyBalance(Energies(2.0, 2.0, 0.0, 0.0), step=0.1)
    balance.judge(Energies(0.5, 0.5, 0.0, 0.0), 1.0)
    assert (balance.error, balance.gain) == (0.75, 0.0)


@pytest.mark.parametrize("kinetic", [9.0, np.nan, np.inf])
def test_a_runaway_is_refused(kinetic: float) -> None:
    balance = EnergyBalance(Energies(1.0, 1.0, 0.0, 0.0), step=0.1)
    with pytest.raises(DivergenceError, match=r"at 3 s .*steps of 0\.1 s are too long"):
        balance.judge(Energies(kinetic, 1.0, 2.0, 0.0), 3.0)


def test_explicit_methods_near_their_limit_are_allowed_more() -> None:
    energies = Energies(9.0, 1.0, 2.0, 0.0)  # gain 1.5
    start = Energies(1.0, 1.0, 0.0, 0.0)
    EnergyBalance(start, step=0.5, limit=1.0).judge(energies, 1.0)
    with pytest.raises(DivergenceError, match=r"gained 1\.5 times"):
        EnergyBalance(start, step=0.1, limit=1.0).judge(energies, 1.0)
    EnergyBalance(start, step=0.1, limit=1.0, lenient=True).judge(energies, 1.0)


def test_what_was_dissipated_does_not_come_back() -> None:
    balance = EnergyBalance(Energies(1.0, 0.0, 0.0, 0.0), step=0.1)
    balance.look(Energies(0.0, 0.0, 0.0, 1.0))
    balance.look(Energies(1.0, 0.0, 0.0, 0.0))
    assert balance.gain == pytest.approx(1.0)
