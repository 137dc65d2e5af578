"""Tractions and following pressure: resultants, derivatives, what is selected."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.errors import SelectionError
from fenics_defo.fem.regions import select_facets
from fenics_defo.fem.sources import Group
from fenics_defo.fem.surface_loads import PressureForm, surface_weights
from tests.unit.fem.fem_bodies import (
    CELLS,
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
    usual_groups,
)
from tests.unit.fem.test_linear_solvers import scipy_matrix
from tests.unit.fem.test_solid import order_of, rotation

Array = NDArray[np.float64]
EVERYWHERE = "x>-1e9"
CURVED = [("tetrahedron", 2, 2), ("hexahedron", 2, 2), ("hexahedron", 1, 2)]


def body(kind: str, order: int, mesh_order: int, mapping: Any = tapered) -> fem.Solid:
    mapping = bent if mesh_order == 2 and mapping is tapered else mapping
    return bar(kind, order, mesh_order, law=SVK, mapping=mapping)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), [*CELLS, *CURVED])
def test_pressure_all_round_has_no_resultant(kind: str, order: int, mesh_order: int) -> None:
    """Nor a moment about the deformed shape, in any state."""
    solid = body(kind, order, mesh_order)
    form = PressureForm(solid, EVERYWHERE)
    for size in (0.0, 0.1, 0.4):
        u = bend(solid, size)
        force = solid.nodes.gather_own(form.force(solid.nodes.scatter(u), 100.0))
        assert abs(force).max() > 1.0
        assert abs(force.sum(axis=0)).max() < 1e-11 * abs(force).sum()
        moment = np.cross(solid.points + u, force)[solid.nodes.carried].sum(axis=0)
        if mesh_order <= order:  # else the nodes do not carry the shape
            assert abs(moment).max() < 1e-11 * abs(force).sum()


def volume(solid: fem.Solid, u: Array) -> float:
    """That of the deformed body, by the divergence theorem over the pressure's own forces."""
    form = PressureForm(solid, EVERYWHERE)
    force = solid.nodes.gather_own(form.force(solid.nodes.scatter(u), -1.0))
    return float((force * (solid.points + u)).sum() / 3.0)


def test_the_volume_inside_the_pressure() -> None:
    solid = body("tetrahedron", 1, 1, straight)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.95, 0.1], [0.05, 0.0, 1.2]])
    u = solid.points @ (F - np.eye(3)).T
    assert volume(solid, 0.0 * u) == pytest.approx(VOLUME, rel=1e-12)
    assert volume(solid, u) == pytest.approx(VOLUME * np.linalg.det(F), rel=1e-12)


def test_pressure_turns_with_the_body() -> None:
    solid = body("hexahedron", 1, 1, straight)
    form, R = PressureForm(solid, "x>1.99"), rotation()
    u = solid.points @ R.T - solid.points
    force = solid.nodes.gather_own(form.force(solid.nodes.scatter(u), 7.0)).sum(axis=0)
    np.testing.assert_allclose(force, -7.0 * SIDES[1] * SIDES[2] * R[:, 0], rtol=1e-12)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CELLS)
def test_the_tangent_of_pressure_is_its_derivative(kind: str, order: int, mesh_order: int) -> None:
    """On a part of the surface; its symmetric part is taken as such."""
    solid = body(kind, order, mesh_order)
    form, p = PressureForm(solid, "x>1.99"), 30.0
    local = solid.nodes.scatter(bend(solid))
    direction = np.random.default_rng(2).standard_normal(local.shape)
    exact, symmetric = (solid.assembly.empty_matrix() for _ in range(2))
    form.add_tangent(exact, local, p, symmetric=False)
    form.add_tangent(symmetric, local, p)
    change = product(exact, direction)

    def error(h: float) -> float:
        ends = [form.force(local + s * h * direction, p) for s in (1.0, -1.0)]
        return float(np.linalg.norm((ends[0] - ends[1]) / (2.0 * h) - change))

    scale = np.linalg.norm(change)
    assert scale > 0.0
    # The force is quadratic in u: central differences leave round-off only.
    assert error(1e-2) < 1e-10 * scale
    whole = scipy_matrix(exact)
    halves = 0.5 * (whole + whole.T) - scipy_matrix(symmetric)
    assert abs(halves).max() < 1e-12 * abs(whole).max()
    exact.destroy()
    symmetric.destroy()


def product(matrix: Any, direction: Array) -> Array:
    x, y = matrix.createVecs()
    x.array[:] = direction.ravel()
    matrix.mult(x, y)
    result = np.array(y.array).reshape(-1, 3)
    x.destroy()
    y.destroy()
    return result


def test_the_force_of_pressure_is_quadratic_so_one_sided_differences_are_of_order_1() -> None:
    solid = body("tetrahedron", 1, 1)
    form, local = PressureForm(solid, EVERYWHERE), solid.nodes.scatter(bend(solid))
    direction = np.random.default_rng(3).standard_normal(local.shape)
    matrix = solid.assembly.empty_matrix()
    form.add_tangent(matrix, local, 5.0, symmetric=False)
    change, now = product(matrix, direction), form.force(local, 5.0)
    matrix.destroy()

    def error(h: float) -> float:
        moved = form.force(local + h * direction, 5.0)
        return float(np.linalg.norm((moved - now) / h - change))

    assert order_of(error, 1e-3) == pytest.approx(1.0, abs=0.05)


def test_all_round_the_tangent_is_symmetric() -> None:
    """The pressure's work is then -p times the volume, so that it has a potential."""
    solid = body("tetrahedron", 1, 1)
    form, local = PressureForm(solid, EVERYWHERE), solid.nodes.scatter(bend(solid))
    exact, symmetric = (solid.assembly.empty_matrix() for _ in range(2))
    form.add_tangent(exact, local, 5.0, symmetric=False)
    form.add_tangent(symmetric, local, 5.0)
    exact.axpy(-1.0, symmetric)
    assert exact.norm() < 1e-12 * symmetric.norm()
    exact.destroy()
    symmetric.destroy()


def test_it_adds_to_what_is_there_but_not_in_held_rows() -> None:
    solid = fem.Solid(mesh_of(source("tetrahedron", mapping=tapered)), NEO, fixed=["x<1e-9"])
    local = solid.nodes.scatter(bend(solid))
    filled = solid.assembly.stiffness_matrix(local, diagonal=4.0)
    both, alone = filled.copy(), solid.assembly.empty_matrix()
    form = PressureForm(solid, EVERYWHERE)
    form.add_tangent(both, local, 1e4)
    form.add_tangent(alone, local, 1e4)
    assert alone.norm() > 0.0
    entries = scipy_matrix(alone).toarray()
    assert not entries[solid.assembly.held.ravel()].any()
    assert not entries[:, solid.assembly.held.ravel()].any()
    both.axpy(-1.0, filled)
    both.axpy(-1.0, alone)
    assert both.norm() < 1e-13 * filled.norm()
    for matrix in (filled, both, alone):
        matrix.destroy()


@pytest.mark.parametrize(("kind", "order", "mesh_order"), [*CELLS, ("tetrahedron", 1, 2)])
def test_the_weights_of_a_traction_are_the_area(kind: str, order: int, mesh_order: int) -> None:
    solid = body(kind, order, mesh_order, straight)
    weights = surface_weights(solid, "x>1.99")
    assert weights.sum() == pytest.approx(SIDES[1] * SIDES[2], rel=1e-12)
    mine = solid.nodes.points[solid.nodes.rows[: solid.nodes.owned]]
    # The resultant acts at the middle of the face.
    np.testing.assert_allclose(
        weights @ mine / weights.sum(), [SIDES[0], SIDES[1] / 2, SIDES[2] / 2], rtol=1e-12
    )
    assert not weights[mine[:, 0] < SIDES[0] - 1e-9].any()


def test_the_area_of_a_curved_face() -> None:
    """The outer side of the ring, of radius 2 over one radian."""
    errors = []
    for cells in (2, 4):
        mesh = source("hexahedron", cells=(cells, 1, 1), order=2, mapping=bent)
        solid = fem.Solid(mesh_of(mesh), SVK, order=2)
        # Corners at radius 2 lie on both x² + z² = 4 and the box's outside; take them by nodes.
        record, radius = solid.record, np.hypot(solid.points[:, 0], solid.points[:, 2])
        outer = record.node_numbers[np.flatnonzero(radius > 1.99)]
        area = surface_weights(solid, nodes_file(outer)).sum()
        errors.append(abs(area - 2.0 * SIDES[1]))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def nodes_file(numbers: NDArray[np.int64]) -> str:
    path = FOLDER[0] / "outer.bou"
    path.write_text(", ".join(map(str, numbers)))
    return f"nodes:{path}"


FOLDER: list[Any] = []


@pytest.fixture(autouse=True)
def _folder(tmp_path: Any) -> None:
    FOLDER[:] = [tmp_path]


def test_groups_of_nodes_name_the_facets_between_them() -> None:
    mesh_data = mesh_of(source("tetrahedron", groups=usual_groups("tetrahedron")))
    by_nodes, by_facets = (select_facets(mesh_data, name) for name in ("pins", "root"))
    assert by_nodes.size
    np.testing.assert_array_equal(by_nodes, by_facets)


def test_facets_inside_the_body_carry_no_load() -> None:
    def inner(points: Array, cells: NDArray[np.int64]) -> list[Group]:
        shared = cells[np.argmin(points[cells].mean(axis=1)[:, 0])]
        # All facets of one cell; at least one lies inside.
        faces = np.array([np.delete(shared, k) for k in range(4)])
        counts = [np.isin(cells, face).sum(axis=1).max(initial=0) for face in faces]
        assert max(counts) == 3
        inside = [f for f in faces if (np.isin(cells, f).sum(axis=1) == 3).sum() == 2]
        return [Group(name="inside", number=3, dimension=2, entities=np.array(inside[:1]))]

    mesh_data = mesh_of(source("tetrahedron", groups=inner))
    assert fem.select_entities(mesh_data, "inside", dimension=2).size == 1
    with pytest.raises(SelectionError, match="'inside' lie inside the body"):
        select_facets(mesh_data, "inside")
