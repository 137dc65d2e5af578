"""Equilibria of uniform strain, found by Newton: each law against its closed forms."""

import numpy as np
import pytest
from bodies import Array, box, box_arrays

from fenics_defo.analysis import Prescribed, Traction, static_equilibrium
from fenics_defo.beams import (
    compressive_limit,
    equibiaxial_tension,
    simple_shear,
    uniaxial_tension,
)
from fenics_defo.energy import (
    Corotational,
    Invertible,
    LinearElastic,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.fem import Fixed, Solid, build_mesh

HOOKE = {"young": 2.6, "poisson": 0.3}
RUBBER = {"c10": 0.3, "c01": 0.2, "bulk": 4.0}
LAWS = {
    "linear": (LinearElastic(**HOOKE, density=1.0), HOOKE),
    "corotational": (Corotational(**HOOKE, density=1.0), HOOKE),
    "st-venant-kirchhoff": (StVenantKirchhoff(**HOOKE, density=1.0), HOOKE),
    "neo-hookean": (NeoHookean(**HOOKE, density=1.0), HOOKE),
    "mooney-rivlin": (MooneyRivlin(**RUBBER, density=1.0), RUBBER),
}
each_law = pytest.mark.parametrize("law", LAWS)
each_space = pytest.mark.parametrize(("kind", "order"), [("tetrahedron", 2), ("hexahedron", 1)])

SIDES = np.array([1.0, 0.8, 0.6])
ROLLERS = [Fixed(f"{c}==0", c) for c in "xyz"]


def uneven(
    law: str, kind: str, order: int, fixed: list[Fixed], *, invertible: bool = False
) -> Solid:
    """A box whose inner nodes are pushed about, so that no two cells are alike."""
    points, cells = box_arrays(kind, (2, 2, 2), SIDES)
    inner = ((points > 1e-9) & (points < SIDES - 1e-9)).all(axis=1)
    points[inner] += 0.05 * np.random.default_rng(2).uniform(-1.0, 1.0, (inner.sum(), 3))
    material = LAWS[law][0]
    chosen = Invertible(material) if invertible else material
    return Solid(build_mesh(points, cells, kind=kind), chosen, order=order, fixed=fixed)


def pulled(solid: Solid, stretch: float, axes: str) -> Array:
    """Displacement when the far ends along ``axes`` are moved and all other sides are free."""
    ends = []
    for axis, side in zip("xyz", SIDES, strict=True):
        if axis in axes:
            moved = [(stretch - 1.0) * side if axis == c else None for c in "xyz"]
            ends.append(Prescribed(f"{axis}=={side}", displacement=tuple(moved)))
    found = static_equilibrium(solid, [], prescribed=ends, load_steps=4, tolerance=1e-10)
    return found.displacement


def end_force(solid: Solid, displacement: Array, axis: int) -> float:
    """Force along ``axis`` on the far end of that axis."""
    end = solid.points[:, axis] > SIDES[axis] - 1e-9
    return float(solid.internal_force(displacement)[end, axis].sum())


@each_law
@each_space
@pytest.mark.parametrize("stretch", [0.75, 1.4])
def test_uniaxial_tension(law: str, kind: str, order: int, stretch: float) -> None:
    solid = uneven(law, kind, order, ROLLERS)
    found = pulled(solid, stretch, "x")
    state = uniaxial_tension(law, stretch=stretch, **LAWS[law][1])
    strain = np.array([stretch, state.free_stretch, state.free_stretch]) - 1.0
    assert found == pytest.approx(solid.points * strain, abs=1e-8)
    area = SIDES[1] * SIDES[2]
    assert end_force(solid, found, 0) == pytest.approx(state.stress * area, rel=1e-8)


@each_law
@each_space
@pytest.mark.parametrize("stretch", [1.3])
def test_equibiaxial_tension(law: str, kind: str, order: int, stretch: float) -> None:
    solid = uneven(law, kind, order, ROLLERS)
    found = pulled(solid, stretch, "xy")
    state = equibiaxial_tension(law, stretch=stretch, **LAWS[law][1])
    strain = np.array([stretch, stretch, state.free_stretch]) - 1.0
    assert found == pytest.approx(solid.points * strain, abs=1e-8)
    for axis in (0, 1):
        area = SIDES.prod() / SIDES[axis]
        assert end_force(solid, found, axis) == pytest.approx(state.stress * area, rel=1e-8)


def sheared(law: str, kind: str, order: int, stress: Array) -> tuple[Solid, Array]:
    """A block held at y = 0 and loaded by P N on its five other faces, and its displacement."""
    solid = uneven(law, kind, order, [Fixed("y==0")])
    loads = [
        Traction(f"{axis}=={at}", vector=tuple(sign * stress[:, i]))
        for i, axis in enumerate("xyz")
        for at, sign in ((0.0, -1.0), (SIDES[i], 1.0))
        if (axis, at) != ("y", 0.0)
    ]
    found = static_equilibrium(solid, loads, load_steps=4, tolerance=1e-10)
    return solid, found.displacement


@each_law
@each_space
def test_simple_shear_by_its_tractions(law: str, kind: str, order: int) -> None:
    """Tractions that belong to simple shear make it: u = g y e_x."""
    amount = 0.4
    stress = simple_shear(law, amount=amount, **LAWS[law][1])
    solid, found = sheared(law, kind, order, stress)
    expected = np.zeros_like(found)
    expected[:, 0] = amount * solid.points[:, 1]
    assert found == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("law", ["neo-hookean", "mooney-rivlin", "st-venant-kirchhoff"])
def test_the_invertible_form_is_the_law_itself_above_its_threshold(law: str) -> None:
    solid = uneven(law, "hexahedron", 1, ROLLERS, invertible=True)
    found = pulled(solid, 1.4, "x")
    state = uniaxial_tension(law, stretch=1.4, **LAWS[law][1])
    strain = np.array([1.4, state.free_stretch, state.free_stretch]) - 1.0
    assert found == pytest.approx(solid.points * strain, abs=1e-8)


def compressed(stretches: Array) -> tuple[Array, Array]:
    """Stretches, and nominal stresses [Pa] of a St. Venant-Kirchhoff column of one cell.

    One cell, for beyond the limit a column of several has other equilibria: one of them gives way.
    """
    material = LAWS["st-venant-kirchhoff"][0]
    solid = Solid(box("hexahedron", (1, 1, 1), SIDES), material, fixed=ROLLERS)
    forces = [end_force(solid, pulled(solid, float(s), "x"), 0) for s in stretches]
    return stretches, np.array(forces) / (SIDES[1] * SIDES[2])


def peak() -> float:
    """Stretch at which the column resists most."""
    near = 3.0**-0.5 + 0.01 * np.arange(-2, 3)
    # The law is a cubic polynomial of the stretch: the fit is no approximation.
    extrema = np.polynomial.Polynomial.fit(*compressed(near), 3).deriv().roots()
    return float(extrema[np.abs(extrema - 3.0**-0.5).argmin()])


def test_st_venant_kirchhoff_has_a_limit_in_compression() -> None:
    """The force of a column whose end is moved peaks at the stretch 1 / sqrt(3), then falls."""
    limit = compressive_limit(young=HOOKE["young"])
    assert peak() == pytest.approx(limit.stretch, rel=1e-6)
    _, forces = compressed(limit.stretch + np.array([-0.05, 0.0, 0.05]))
    assert forces[1] == pytest.approx(limit.stress, rel=1e-9)
    assert forces[1] < min(forces[0], forces[2])
