"""Slender beams bent far: Euler's elastica under an end force, and rolled up by an end moment."""

from functools import cache

import numpy as np
import pytest
from bodies import Array, box, orders

from fenics_defo.analysis import Pressure, Traction, static_equilibrium
from fenics_defo.beams import (
    RectangularSection,
    TipPose,
    elastica_end_force,
    elastica_end_moment,
)
from fenics_defo.energy import Corotational, Material, NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid

# Without Poisson's effect neither the clamp nor curvature across the section stiffens the beam.
CONSTANTS = {"young": 1.0e9, "poisson": 0.0, "density": 1000.0}
LAWS = {
    "st-venant-kirchhoff": StVenantKirchhoff(**CONSTANTS),
    "neo-hookean": NeoHookean(**CONSTANTS),
    "corotational": Corotational(**CONSTANTS),
}
LENGTH = 1.0


def beam(material: Material, cells: int, side: float) -> Solid:
    """Cantilever along x of second-order hexahedra, two of them over the height."""
    mesh = box("hexahedron", (cells, 1, 2), (LENGTH, side, side))
    return Solid(mesh, material, order=2, fixed=["x==0"])


def tip(solid: Solid, displacement: Array, side: float) -> TipPose:
    """Pose of the end section: its middle, and the turn of the line between its edges."""
    now = solid.points + displacement
    end = np.abs(solid.points[:, 0] - LENGTH) < 1e-9
    middle = end & (np.abs(solid.points[:, 1:] - 0.5 * side) < 1e-9).all(axis=1)
    x, _, z = now[middle][0]
    top = now[end & (solid.points[:, 2] > side - 1e-9)].mean(axis=0)
    low = now[end & (solid.points[:, 2] < 1e-9)].mean(axis=0)
    along = top - low
    return TipPose(x, z - 0.5 * side, float(np.arctan2(-along[0], along[2])))


def under_end_force(law: str, load: float, cells: int, side: float) -> TipPose:
    """Tip under a dead traction with F L² / (E I) = load."""
    solid = beam(LAWS[law], cells, side)
    force = load * CONSTANTS["young"] * side**4 / 12.0 / LENGTH**2
    pull = Traction(f"x=={LENGTH}", vector=(0.0, 0.0, force / side**2))
    found = static_equilibrium(solid, [pull], load_steps=4)
    return tip(solid, found.displacement, side)


@cache
def end_force_errors(law: str, load: float, cells: int, side: float) -> Array:
    """Of x, z [lengths of the beam] and rotation [rad]."""
    mine = under_end_force(law, load, cells, side)
    force = load * CONSTANTS["young"] * side**4 / 12.0 / LENGTH**2
    section = RectangularSection(side, side)
    theirs = elastica_end_force(length=LENGTH, section=section, young=1.0e9, force=force)
    return np.array([mine.x - theirs.x, mine.y - theirs.y, mine.rotation - theirs.rotation])


@pytest.mark.parametrize("law", LAWS)
def test_dead_end_force(law: str) -> None:
    """At F L² / (E I) = 4 the tip hangs by two thirds of the length, to a thousandth of it."""
    assert np.abs(end_force_errors(law, 4.0, 24, 0.02)).max() < 1e-3


def test_strong_end_force() -> None:
    """F L² / (E I) = 10 turns the tip by 82 degrees."""
    assert np.abs(end_force_errors("st-venant-kirchhoff", 10.0, 24, 0.02)).max() < 3e-3


def test_end_force_converges_to_the_elastica() -> None:
    """What is left on a fine mesh is shear and extension, of second order in the thickness."""
    thick, thin = (
        end_force_errors("corotational", 4.0, cells, side)
        for cells, side in ((32, 0.04), (64, 0.02))
    )
    assert orders([thick, thin])[0] == pytest.approx(np.full(3, 2.0), abs=0.3)


def rolled(law: str, cells: int, side: float, turns: float) -> TipPose:
    """Tip under the end moment that bends the elastica into ``turns`` circles.

    The moment is a couple of pressures ±p on the two halves of the end section, which follow it:
    M = p b h² / 4.
    """
    solid = beam(LAWS[law], cells, side)
    moment = 2.0 * np.pi * turns * CONSTANTS["young"] * side**4 / 12.0 / LENGTH
    pressure = 4.0 * moment / side**3
    half = 0.5 * side
    loads = [
        Pressure(f"x=={LENGTH} and z>={half}", value=pressure),
        Pressure(f"x=={LENGTH} and z<={half}", value=-pressure),
    ]
    found = static_equilibrium(solid, loads, load_steps=round(16 * turns))
    return tip(solid, found.displacement, side)


@pytest.mark.parametrize("turns", [0.5, 1.0])
def test_rolled_up(turns: float) -> None:
    """The corotational law's stress is linear in the stretch: a circle, however thick the beam."""
    side = 0.02
    mine = rolled("corotational", 24, side, turns)
    theirs = elastica_end_moment(
        length=LENGTH,
        section=RectangularSection(side, side),
        young=1.0e9,
        moment=2.0 * np.pi * turns * 1.0e9 * side**4 / 12.0,
    )
    assert mine.x == pytest.approx(theirs.x, abs=2e-3)
    assert mine.y == pytest.approx(theirs.y, abs=2e-3)
    # arctan2 knows the rotation but for whole turns.
    assert np.sin(mine.rotation - theirs.rotation) == pytest.approx(0.0, abs=0.01)
