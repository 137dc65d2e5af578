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


def axis_line(solid: Solid, displacement: Array, side: float) -> Array:
    """(k, 2) places x, z of the nodes on the beam's axis, from the clamp on."""
    on_axis = (np.abs(solid.points[:, 1:] - 0.5 * side) < 1e-9).all(axis=1)
    now = (solid.points + displacement)[on_axis]
    return now[np.argsort(solid.points[on_axis, 0])][:, [0, 2]] - [0.0, 0.5 * side]


def bending_stiffness(side: float) -> float:
    """E I [N m²]."""
    return CONSTANTS["young"] * side**4 / 12.0


def bent(law: str, load: float, cells: int, side: float) -> tuple[Solid, Array]:
    """The beam and its displacement under a dead end traction with F L² / (E I) = load."""
    solid = beam(LAWS[law], cells, side)
    force = load * bending_stiffness(side) / LENGTH**2
    pull = Traction(f"x=={LENGTH}", vector=(0.0, 0.0, force / side**2))
    return solid, static_equilibrium(solid, [pull], load_steps=4).displacement


def elastica(load: float, side: float) -> TipPose:
    """Theory's tip under that force."""
    return elastica_end_force(
        length=LENGTH,
        section=RectangularSection(side, side),
        young=CONSTANTS["young"],
        force=load * bending_stiffness(side) / LENGTH**2,
    )


@cache
def end_force_errors(law: str, load: float, cells: int, side: float) -> Array:
    """Of x, z [lengths of the beam] and rotation [rad]."""
    mine, theirs = tip(*bent(law, load, cells, side), side), elastica(load, side)
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


def rolled(law: str, cells: int, side: float, turns: float) -> tuple[Solid, Array]:
    """The beam and its displacement under the end moment that makes ``turns`` circles.

    The moment is a couple of pressures ±p on the two halves of the end section, which follow it:
    M = p b h² / 4.
    """
    solid = beam(LAWS[law], cells, side)
    pressure = 4.0 * 2.0 * np.pi * turns * bending_stiffness(side) / LENGTH / side**3
    half = 0.5 * side
    loads = [
        Pressure(f"x=={LENGTH} and z>={half}", value=pressure),
        Pressure(f"x=={LENGTH} and z<={half}", value=-pressure),
    ]
    found = static_equilibrium(solid, loads, load_steps=max(round(16 * turns), 1))
    return solid, found.displacement


def circle(turns: float, side: float) -> TipPose:
    """Theory's tip under that moment."""
    return elastica_end_moment(
        length=LENGTH,
        section=RectangularSection(side, side),
        young=CONSTANTS["young"],
        moment=2.0 * np.pi * turns * bending_stiffness(side) / LENGTH,
    )


@pytest.mark.parametrize("turns", [0.5, 1.0])
def test_rolled_up(turns: float) -> None:
    """The corotational law's stress is linear in the stretch: a circle, however thick the beam."""
    side = 0.02
    mine, theirs = tip(*rolled("corotational", 24, side, turns), side), circle(turns, side)
    assert mine.x == pytest.approx(theirs.x, abs=2e-3)
    assert mine.y == pytest.approx(theirs.y, abs=2e-3)
    # arctan2 knows the rotation but for whole turns.
    assert np.sin(mine.rotation - theirs.rotation) == pytest.approx(0.0, abs=0.01)
