"""Slender beams bent far: Euler's elastica under an end force, and rolled up by an end moment."""

from functools import cache, partial

import numpy as np
import pytest
from bodies import Array, box, orders

from fenics_defo.analysis import Prescribed, QuasiStatic, Traction, simulate, static_equilibrium
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


def circle(turns: float, side: float) -> TipPose:
    """Theory's tip under the end moment that makes ``turns`` circles."""
    return elastica_end_moment(
        length=LENGTH,
        section=RectangularSection(side, side),
        young=CONSTANTS["young"],
        moment=2.0 * np.pi * turns * bending_stiffness(side) / LENGTH,
    )


def turned_end(side: float, turns: float) -> list[Prescribed]:
    """The end section carried plane along the tip's way to the circle, in one second.

    The tip of an elastica under a growing end moment rotates in proportion to it.
    """

    def sideways(time: float, height: float) -> float:
        pose = circle(turns * time, side)
        return pose.x - height * np.sin(pose.rotation) - LENGTH

    def upwards(time: float, height: float) -> float:
        pose = circle(turns * time, side)
        return pose.y + height * np.cos(pose.rotation) - height

    levels = side * np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    return [
        Prescribed(f"x=={LENGTH} and z=={z}", displacement=way, history=partial(move, height=h))
        for z, h in zip(levels, levels - 0.5 * side, strict=True)
        for way, move in (((1.0, None, None), sideways), ((None, None, 1.0), upwards))
    ]


@cache
def rolled(law: str, cells: int, side: float, turns: float) -> tuple[Solid, Array]:
    """The beam, and its displacements (k, n, 3) while its end is turned, in steps."""
    solid = beam(LAWS[law], cells, side)
    steps = round(12 * turns)
    found: list[Array] = []
    simulate(
        solid,
        [],
        QuasiStatic(),
        step=1.0 / steps,
        duration=1.0,
        newton=None,
        newton_tolerance=1e-8,
        newton_iterations=40,
        prescribed=turned_end(side, turns),
        observe=lambda simulation: found.append(simulation.state.displacement),
        energies_every=0,
    )
    return solid, np.array(found)


def end_loads(solid: Solid, displacement: Array, side: float) -> tuple[Array, float]:
    """Force (3,) [N] upon the end section, and moment about its middle [N m], by z over x."""
    end = np.abs(solid.points[:, 0] - LENGTH) < 1e-9
    pose = tip(solid, displacement, side)
    force = solid.internal_force(displacement)[end]
    arm = (solid.points + displacement)[end] - [pose.x, 0.5 * side, pose.y + 0.5 * side]
    return force.sum(axis=0), float((arm[:, 0] * force[:, 2] - arm[:, 2] * force[:, 0]).sum())


def test_rolled_up() -> None:
    """Held on the elastica's way, the end needs a moment E I theta / L alone: no force at all.

    And the beam's axis lies on the circle, into which it closes.
    """
    side = 0.02
    solid, way = rolled("corotational", 20, side, 1.0)
    for part in (0.5, 1.0):
        displacement = way[round(part * (len(way) - 1))]
        force, moment = end_loads(solid, displacement, side)
        theory = 2.0 * np.pi * part * bending_stiffness(side) / LENGTH
        assert moment == pytest.approx(theory, rel=0.02)
        assert np.linalg.norm(force) * LENGTH < 2e-3 * theory
        radius = LENGTH / (2.0 * np.pi * part)
        axis = axis_line(solid, displacement, side) - [0.0, radius]
        assert np.hypot(*axis.T) == pytest.approx(radius, abs=1e-4 * LENGTH)
