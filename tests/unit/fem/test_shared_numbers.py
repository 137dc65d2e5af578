"""Gmsh numbers the groups of each dimension anew: a constraint means the facets of that number."""

import numpy as np

from fenics_defo import fem
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem.compat import MPI
from fenics_defo.fem.distribution import distribute
from fenics_defo.fem.sources import Group, SourceMesh

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
STEEL = StVenantKirchhoff(young=2e11, poisson=0.3, density=7850.0)


def test_a_number_of_facets_and_cells_holds_the_facets() -> None:
    source = SourceMesh(
        points=POINTS,
        cells=np.array([[0, 1, 2, 3]]),
        kind="tetrahedron",
        order=1,
        node_numbers=np.arange(1, 5),
        cell_numbers=np.array([1]),
        groups=(
            Group(name="body", number=1, dimension=3, entities=np.array([0])),
            Group(name="floor", number=1, dimension=2, entities=np.array([[0, 1, 2]])),
        ),
    )
    mesh = distribute(MPI.COMM_WORLD, source)
    held = fem.Solid(mesh, STEEL, fixed=[1]).held
    np.testing.assert_array_equal(held.all(axis=1), [True, True, True, False])
    assert fem.Solid(mesh, {1: STEEL}).total_mass() > 0.0
    assert fem.Solid(mesh, STEEL, fixed=["body"]).held.all()
