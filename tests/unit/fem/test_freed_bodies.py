"""A body that nobody needs any more leaves nothing behind."""

import gc
import weakref

import numpy as np
import pytest

from fenics_defo import energy
from fenics_defo.fem import Solid
from tests.unit.fem.fem_bodies import mesh_of, source

HOOKE = {"young": 1.0, "poisson": 0.3, "density": 1.0}


@pytest.mark.parametrize(
    "law", [energy.NeoHookean, energy.Corotational], ids=lambda law: law.__name__
)
def test_forms_and_fields_go_with_their_body(law):
    solid = Solid(mesh_of(source("tetrahedron", cells=(1, 1, 1))), law(**HOOKE))
    displacement = np.zeros((solid.nodes.size, 3))
    solid.energy(displacement)
    solid.internal_force(displacement)
    solid.tangent(displacement)
    kept = [weakref.ref(thing) for thing in (solid, solid.assembly, solid.space)]
    del solid
    gc.collect()
    assert [thing() for thing in kept] == [None] * 3
