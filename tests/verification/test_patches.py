"""Patch tests: what the boundary does affinely, the whole body does, at rest and in motion.

With u = t G X on the boundary and v = G X at the start no node is ever accelerated and the stress
is the same everywhere: an exact solution for any law, any mesh and any integrator.
"""

import numpy as np
import pytest
from bodies import Array, box_arrays
from motions import EXPLICIT, INTEGRATORS, states

from fenics_defo.analysis import Initial, Prescribed, Ramp, static_equilibrium
from fenics_defo.energy import Corotational, LinearElastic, NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid, build_mesh

SIDES = np.array([1.0, 0.8, 0.6])
GRADIENT = np.array([[0.2, 0.3, -0.1], [0.05, -0.15, 0.2], [-0.15, 0.1, 0.1]])
CONSTANTS = {"young": 2.6, "poisson": 0.3, "density": 1.0}
LAWS = [LinearElastic, Corotational, StVenantKirchhoff, NeoHookean]


def uneven(law: type, kind: str) -> Solid:
    """A box of order 1 whose inner nodes are pushed about."""
    points, cells = box_arrays(kind, (3, 3, 2), SIDES)
    inner = ((points > 1e-9) & (points < SIDES - 1e-9)).all(axis=1)
    points[inner] += 0.05 * np.random.default_rng(3).uniform(-1.0, 1.0, (inner.sum(), 3))
    return Solid(build_mesh(points, cells, kind=kind), law(**CONSTANTS))


def boundary_motion(solid: Solid, gradient: Array) -> list[Prescribed]:
    """Each node of the boundary moves by ``gradient`` times its place, in one second."""
    points = solid.points
    outer = points[((points < 1e-9) | (points > SIDES - 1e-9)).any(axis=1)]
    return [
        Prescribed(
            f"x=={x!r} and y=={y!r} and z=={z!r}",
            displacement=tuple(gradient @ (x, y, z)),
            history=Ramp(1.0),
        )
        for x, y, z in outer.tolist()
    ]


@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize("law", LAWS)
def test_static_patch(law: type, kind: str) -> None:
    solid = uneven(law, kind)
    moved = boundary_motion(solid, GRADIENT)
    found = static_equilibrium(solid, [], prescribed=moved, tolerance=1e-11, load_steps=2)
    assert found.displacement == pytest.approx(solid.points @ GRADIENT.T, abs=1e-9)


@pytest.mark.parametrize("name", INTEGRATORS)
@pytest.mark.parametrize("law", [LinearElastic, StVenantKirchhoff])
def test_dynamic_patch(name: str, law: type) -> None:
    solid = uneven(law, "tetrahedron")
    found = states(
        solid,
        INTEGRATORS[name],
        step=0.01 if name in EXPLICIT else 0.1,
        count=40 if name in EXPLICIT else 8,
        newton=None,
        newton_tolerance=1e-10,
        prescribed=boundary_motion(solid, GRADIENT),
        initial=Initial(velocity=solid.points @ GRADIENT.T),
    )
    for state in (found[len(found) // 2], found[-1]):
        expected = state.time * solid.points @ GRADIENT.T
        assert state.displacement == pytest.approx(expected, abs=1e-8)
        assert state.velocity == pytest.approx(solid.points @ GRADIENT.T, abs=1e-7)
