"""A free sphere against Lamb's exact spectrum: curved cells, multiple frequencies."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from bodies import Array, drawn, orders

from fenics_defo.analysis import linear_modes
from fenics_defo.beams import sphere_frequencies
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Solid
from fenics_defo.runtime import Modes
from meshes.sphere import sphere

CONSTANTS = {"young": 1.0, "poisson": 0.3, "density": 1.0}
# Torsional n = 2, spheroidal n = 2, spheroidal n = 1, torsional n = 3: 5 + 5 + 3 + 7 modes.
LAMB = sphere_frequencies(radius=1.0, count=4, **CONSTANTS)
EXACT = LAMB.repeated()


@cache
def ball(folder: Path, size: float, mesh_order: int) -> Modes:
    mesh = drawn(sphere, folder, size=size, order=mesh_order)
    solid = Solid(mesh, StVenantKirchhoff(**CONSTANTS), order=2)
    return linear_modes(solid, 6 + len(EXACT))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(tmp_path_factory.mktemp("ball"))


def errors(modes: Modes) -> Array:
    return modes.frequencies[6:26] / EXACT - 1.0


def test_lamb_spectrum(folder: Path) -> None:
    """Families, multiplicities and values: 5, 5, 3 and 7 modes within 0.5 %, close together."""
    modes = ball(folder, 0.3, 2)
    assert LAMB.multiplicities.tolist() == [5, 5, 3, 7]
    assert modes.rigid_modes == 6
    assert np.abs(errors(modes)).max() < 0.005
    assert np.abs(errors(modes))[:10].max() < 0.0015
    start = 6
    for many in LAMB.multiplicities:
        cluster = modes.frequencies[start : start + many]
        assert np.ptp(cluster) < 1e-3 * cluster[0]
        start += many


def test_torsional_modes_are_tangential(folder: Path) -> None:
    """Toroidal motion u = r x grad ψ has no radial part; of a spheroidal one it is a large part."""
    modes = ball(folder, 0.3, 2)
    radial = np.einsum("knc,nc->kn", modes.shapes, modes.points)
    radial /= np.maximum(np.linalg.norm(modes.points, axis=1), 1e-12)
    share = (modes.node_mass * radial**2).sum(axis=1)
    share /= np.einsum("n,knc->k", modes.node_mass, modes.shapes**2)
    assert share[6:11].max() < 1e-3
    assert share[11:16].min() > 0.1


def mean_errors(modes: Modes) -> Array:
    """Mean error of each cluster."""
    return np.add.reduceat(errors(modes), [0, 5, 10, 13]) / LAMB.multiplicities


def test_fourth_order_on_curved_cells(folder: Path) -> None:
    """λ_h - λ = O(h⁴) on a curved body too, h by the number of nodes: the meshes are not nested."""
    coarse, fine = ball(folder, 0.6, 2), ball(folder, 0.3, 2)
    ratio = (len(fine.points) / len(coarse.points)) ** (1.0 / 3.0)
    observed = orders([mean_errors(coarse), mean_errors(fine)], ratio=ratio)
    assert observed == pytest.approx(np.full((1, 4), 4.0), abs=1.0)


def test_flat_faces_spoil_the_second_order(folder: Path) -> None:
    """Displacements of order 2 on straight cells see a polyhedron, whose lost volume they feel."""
    curved, flat = mean_errors(ball(folder, 0.3, 2)), mean_errors(ball(folder, 0.3, 1))
    assert (flat > 3.0 * curved).all()
