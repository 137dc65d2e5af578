"""A tuning fork: the tone that a steel fork of these dimensions is sold for."""

from pathlib import Path

import numpy as np
import pytest
from bodies import drawn

from fenics_defo.analysis import linear_modes
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Solid
from meshes.tuning_fork import tuning_fork


def test_concert_pitch(tmp_path: Path) -> None:
    """The mode whose prongs swing against each other in the plane of the fork sounds 440 Hz."""
    steel = StVenantKirchhoff(young=2.06e11, poisson=0.29, density=7850.0)
    solid = Solid(drawn(tuning_fork, tmp_path), steel, order=2, fixed=["stem_end"])
    modes = linear_modes(solid, 6)
    tips = solid.points[:, 2] > solid.points[:, 2].max() - 1e-6
    right = tips & (solid.points[:, 0] > 0.0)
    left = tips & (solid.points[:, 0] < 0.0)
    prongs = np.array([modes.shapes[:, side].mean(axis=1) for side in (right, left)])
    # Opposite along x, with hardly any motion out of the plane.
    against = prongs[0, :, 0] * prongs[1, :, 0] / (prongs**2).sum(axis=(0, 2))
    fork = np.flatnonzero(against < -0.45)
    assert modes.frequencies[fork[0]] == pytest.approx(440.0, rel=0.01)
    # It does not shake the hand: the stem's end feels none of it to first order.
    effective = modes.participation[fork[0], :2] ** 2 / modes.total_mass
    assert effective.max() < 1e-4
