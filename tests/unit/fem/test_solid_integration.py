"""Masses, volumes and how exactly the quadrature rules give them."""

from typing import Any

import numpy as np
import pytest

from fenics_defo import fem
from fenics_defo.fem.forms import default_degrees
from tests.unit.fem.fem_bodies import (
    BENT_VOLUME,
    CELLS,
    KINDS,
    NEO,
    SIDES,
    SVK,
    VOLUME,
    bar,
    bend,
    bent,
    mesh_of,
    source,
    straight,
    tapered,
)


def component_mass(solid: fem.Solid) -> Any:
    """Mass matrix (n, n) of one component."""
    return solid.mass()[::3, ::3]


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CELLS)
def test_volume_and_inertia_of_a_box(kind: str, order: int, mesh_order: int) -> None:
    solid = bar(kind, order, mesh_order, mapping=straight)
    a, b, c = SIDES
    mass = component_mass(solid)
    x, y, z = solid.points.T
    rho = NEO.density
    assert solid.total_mass() == pytest.approx(rho * VOLUME, rel=1e-13)
    assert mass.sum() == pytest.approx(rho * VOLUME, rel=1e-13)
    np.testing.assert_allclose(
        [mass.sum(axis=0) @ x, x @ mass @ x, x @ mass @ y, z @ mass @ z],
        rho * VOLUME * np.array([a / 2, a * a / 3, a * b / 4, c * c / 3]),
        rtol=1e-12,
    )


@pytest.mark.parametrize(
    ("kind", "order", "mesh_order"), [*CELLS, ("tetrahedron", 1, 2), ("hexahedron", 1, 2)]
)
def test_lumped_masses(kind: str, order: int, mesh_order: int) -> None:
    solid = bar(kind, order, mesh_order, mapping=tapered if mesh_order == 1 else bent)
    lumped = solid.lumped_mass()
    assert lumped.shape == (solid.nodes.size,)
    assert (lumped[solid.nodes.carried] > 0.0).all()
    assert not lumped[~solid.nodes.carried].any()
    assert lumped.sum() == pytest.approx(solid.total_mass(), rel=1e-13)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_curved_cells_fill_a_ring_to_fourth_order(kind: str, order: int) -> None:
    """Mid nodes on the ring: the error of the volume falls by 16 where straight cells give 4."""

    def error(cells: int, mesh_order: int) -> float:
        mesh = source(kind, cells=(cells, 1, 1), order=mesh_order, mapping=bent)
        solid = fem.Solid(mesh_of(mesh), NEO, order=order)
        return abs(solid.total_mass() / NEO.density / BENT_VOLUME - 1.0)

    assert np.log2(error(2, 1) / error(4, 1)) == pytest.approx(2.0, abs=0.1)
    assert np.log2(error(2, 2) / error(4, 2)) == pytest.approx(4.0, abs=0.2)
    assert error(4, 2) < 1e-3 * error(4, 1) * 20


@pytest.mark.parametrize("order", [1, 2])
def test_the_energy_of_straight_tetrahedra_is_integrated_exactly(order: int) -> None:
    """St. Venant-Kirchhoff: a polynomial of fourth degree in grad u."""
    solid = bar("tetrahedron", order, law=SVK)
    finer = with_degree(solid, 8)
    u = bend(solid, 0.5)
    assert solid.energy(u) == pytest.approx(finer.energy(u), rel=1e-13)


@pytest.mark.parametrize(
    ("kind", "order", "mesh_order", "bound"),
    [
        ("hexahedron", 1, 1, 4e-3),
        ("hexahedron", 2, 1, 1e-4),
        ("tetrahedron", 2, 2, 1e-3),
        ("hexahedron", 2, 2, 1e-4),
    ],
)
def test_the_default_rules_of_other_cells_are_close(
    kind: str, order: int, mesh_order: int, bound: float
) -> None:
    """Below the error of the mesh itself, which is coarse: 2 x 2 x 2 boxes."""
    solid = bar(kind, order, mesh_order, law=SVK, mapping=tapered if mesh_order == 1 else bent)
    u = bend(solid, 0.5)
    assert solid.energy(u) == pytest.approx(with_degree(solid, 12).energy(u), rel=bound)


def with_degree(solid: fem.Solid, degree: int) -> fem.Solid:
    degrees = fem.QuadratureDegrees(energy=degree, rest=degree, mass=degree)
    return fem.Solid(solid.mesh_data, solid.materials, order=solid.order, degrees=degrees)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_curved_cells_never_get_a_lower_rule(kind: str, order: int) -> None:
    plain, curved = (default_degrees(kind, order, mesh_order) for mesh_order in (1, 2))
    for name in ("energy", "rest", "mass"):
        assert getattr(curved, name) >= getattr(plain, name)
