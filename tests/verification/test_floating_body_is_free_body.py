"""A floating body with all shapes that its mesh has, against the full simulation of the free body.

Both are of second order in the step: what differs falls with its square, and what a Richardson
extrapolation leaves is the same motion.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from bodies import Array, box
from flying_bodies import deformations, galerkin_flyer
from motions import CONSTANTS, INTEGRATORS, states

from fenics_defo.analysis import Gravity, Initial, PointLoad, simulate
from fenics_defo.energy import NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid
from fenics_defo.runtime import FloatingBody

SPIN, VELOCITY = np.array([0.8, -1.4, 2.2]), np.array([0.3, 0.2, -0.5])
GRAVITY, FORCE, NODE = (0.0, 1.0, -9.8), (15.0, 6.0, -12.0), 0
DURATION = 0.2


@cache
def body(law: type) -> tuple[Solid, Any]:
    """Two cells, 30 shapes."""
    solid = Solid(box("hexahedron", (2, 1, 1), (1.0, 0.3, 0.25)), law(**CONSTANTS))
    _, shapes = deformations(solid)
    return solid, galerkin_flyer(solid, shapes)


def bent(model: Any) -> Array:
    """Coordinates of a strain of some percent."""
    q = np.zeros(model.frame.size)
    q[:4] = (0.3, -0.2, 0.2, 0.1)
    return q


def full_motion(law: type, count: int, *, loaded: bool) -> Array:
    solid, model = body(law)
    start = solid.points + model.shapes @ bent(model)
    place = tuple(float(x) for x in solid.points[NODE])
    loads: list[Any] = [Gravity(GRAVITY), PointLoad(point=place, vector=FORCE)] if loaded else []
    velocity = VELOCITY + np.cross(SPIN, start - model.frame.centre)
    last = states(
        solid,
        INTEGRATORS["newmark"],
        step=DURATION / count,
        count=count,
        loads=loads,
        newton=None,
        newton_tolerance=1e-9,
        initial=Initial(displacement=start - solid.points, velocity=velocity),
    )[-1]
    return last.displacement


def floating_motion(
    law: type, count: int, *, loaded: bool, newton: int | None = None, coupling: Any = "full"
) -> Array:
    _, model = body(law)
    flyer = FloatingBody(
        model,
        step=DURATION / count,
        newton=newton,
        coupling=coupling,
        velocity=VELOCITY,
        angular_velocity=SPIN,
        q=bent(model),
    )
    loads: dict[str, Any] = {"gravity": GRAVITY, "forces": [(NODE, FORCE)]} if loaded else {}
    for _ in range(count):
        flyer.advance(**loads)
    return flyer.world_displacement()


@pytest.mark.parametrize(
    ("law", "loaded", "newton"),
    [(StVenantKirchhoff, False, None), (StVenantKirchhoff, True, 1), (NeoHookean, True, None)],
)
def test_all_shapes_are_the_full_body(law: type, loaded: bool, newton: int | None) -> None:
    counts = (40, 80)
    full = [full_motion(law, n, loaded=loaded) for n in counts]
    own = [floating_motion(law, n, loaded=loaded, newton=newton) for n in counts]
    scale = np.abs(full[-1]).max()
    apart = [np.abs(a - b).max() / scale for a, b in zip(own, full, strict=True)]
    assert np.log2(apart[0] / apart[1]) == pytest.approx(2.0, abs=0.3)
    assert apart[1] < 3e-3
    limits = [(4.0 * fine - coarse) / 3.0 for coarse, fine in (full, own)]
    assert limits[0] == pytest.approx(limits[1], abs=(1e-3 if newton == 1 else 5e-5) * scale)
    # Without the coupling terms it is another motion.
    other = floating_motion(law, counts[1], loaded=loaded, newton=newton, coupling="none")
    assert np.abs(other - full[1]).max() > 0.02 * scale


def test_momentum_of_both() -> None:
    """Round-off against second order, at the same step."""
    solid, model = body(StVenantKirchhoff)
    start = solid.points + model.shapes @ bent(model)
    velocity = VELOCITY + np.cross(SPIN, start - model.frame.centre)
    lost: list[float] = []

    def observe(simulation: Any) -> None:
        lost.append(float(simulation.momentum()[1][2]))

    simulate(
        solid,
        [],
        INTEGRATORS["newmark"],
        step=0.02,
        duration=0.4,
        newton=None,
        initial=Initial(displacement=start - solid.points, velocity=velocity),
        observe=observe,
        energies_every=0,
    )
    flyer = FloatingBody(model, step=0.02, velocity=VELOCITY, angular_velocity=SPIN, q=bent(model))
    before = flyer.momentum()[1]
    assert before[2] == pytest.approx(lost[0], rel=1e-12)
    for _ in range(20):
        flyer.advance()
    assert np.abs(flyer.momentum()[1] - before).max() < 1e-12 * np.abs(before).max()
    assert abs(lost[-1] - lost[0]) > 1e-6 * abs(lost[0])
