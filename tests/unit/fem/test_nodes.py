"""Node numbering: everything the user sees is in the order of the file."""

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.nodes import NodeNumbering, number_nodes
from fenics_defo.fem.sources import SourceMesh
from fenics_defo.fem.sources.cell_shapes import CellShape, jacobian_determinants
from tests.unit.fem.fem_bodies import KINDS, bent, box, mesh_of, source, straight, tapered

Array = NDArray[np.float64]

CASES = list(itertools.product(KINDS, (1, 2), (1, 2)))


def numbered(mesh: SourceMesh, order: int) -> tuple["dolfinx.fem.FunctionSpace", NodeNumbering]:
    space = dolfinx.fem.functionspace(mesh_of(mesh).mesh, ("Lagrange", order, (3,)))
    return space, number_nodes(space, len(mesh.cells))


@pytest.mark.parametrize("mapping", [straight, bent])
@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
def test_the_users_nodes_and_cells_come_first_and_unchanged(
    kind: str, order: int, mesh_order: int, mapping: object
) -> None:
    mesh = source(kind, order=mesh_order, mapping=mapping)
    _, nodes = numbered(mesh, order)
    n, c = len(mesh.points), mesh.cells.shape[1]
    np.testing.assert_array_equal(nodes.points[:n], mesh.points)
    np.testing.assert_array_equal(nodes.cells[:, :c], mesh.cells)
    assert nodes.file_nodes == n
    assert (nodes.size > n) == (order > mesh_order)
    shape = CellShape(kind, max(order, mesh_order))
    assert nodes.cells.shape[1] == len(shape.reference_nodes)
    assert (
        jacobian_determinants(nodes.points, nodes.cells, shape=shape, at=shape.probes) > 0.0
    ).all()


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
@pytest.mark.parametrize("mapping", [straight, tapered, bent])
def test_each_dof_lies_at_its_row(kind: str, order: int, mesh_order: int, mapping: object) -> None:
    """DOLFINx's own coordinates of the dofs, which the numbering does not use."""
    space, nodes = numbered(source(kind, order=mesh_order, mapping=mapping), order)
    np.testing.assert_allclose(
        space.tabulate_dof_coordinates(), nodes.points[nodes.rows], atol=1e-14
    )
    assert len(np.unique(nodes.rows)) == len(nodes.rows) == nodes.carried.sum()
    assert nodes.carried.all() == (order >= mesh_order)


@pytest.mark.parametrize("kind", KINDS)
def test_extra_nodes_follow_the_files_cells_in_vtk_order(kind: str) -> None:
    mesh = source(kind, mapping=tapered)
    _, nodes = numbered(mesh, 2)
    corners = mesh.cells.shape[1]
    for column, entity in enumerate(CellShape(kind, 2).entities):
        middle = mesh.points[mesh.cells[:, list(entity)]].mean(axis=1)
        np.testing.assert_allclose(nodes.points[nodes.cells[:, column]], middle, atol=1e-15)
    extra = nodes.cells[:, corners:].ravel()
    _, first = np.unique(extra, return_index=True)
    np.testing.assert_array_equal(extra[np.sort(first)], np.arange(len(mesh.points), nodes.size))


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
def test_gathering_what_was_scattered(kind: str, order: int, mesh_order: int) -> None:
    """Any field comes back; on cells of higher order than the space, a first-order one does."""
    _, nodes = numbered(source(kind, order=mesh_order, mapping=bent), order)
    rng = np.random.default_rng(3)
    for shape in ((), (3,), (2, 3)):
        values = rng.standard_normal((nodes.size, *shape))
        back = nodes.gather(nodes.scatter(values))
        np.testing.assert_array_equal(back[nodes.carried], values[nodes.carried])
        own = nodes.gather_own(nodes.scatter(values))
        np.testing.assert_array_equal(own[nodes.carried], values[nodes.carried])
        assert not own[~nodes.carried].any()
    flat = source(kind, order=mesh_order)
    _, nodes = numbered(flat, order)
    linear = nodes.points @ rng.standard_normal((3, 3)) + rng.standard_normal(3)
    np.testing.assert_allclose(nodes.gather(nodes.scatter(linear)), linear, atol=1e-14)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
def test_an_interpolated_field_comes_out_at_the_users_nodes(
    kind: str, order: int, mesh_order: int
) -> None:
    """Of the degree that the space holds: quadratic, or linear."""
    space, nodes = numbered(source(kind, order=mesh_order), order)

    def field(x: Array) -> Array:
        return np.stack([x[0] + 2.0, x[1] - x[2], (x[0] * x[1] if order == 2 else x[0]) + x[2]])

    u = dolfinx.fem.Function(space)
    u.interpolate(field)
    np.testing.assert_allclose(
        nodes.gather(u.x.array.reshape(-1, 3)), field(nodes.points.T).T, atol=1e-13
    )


def test_a_twenty_node_hexahedron_becomes_one_of_27() -> None:
    points, cells = box("hexahedron", order=2, mapping=tapered, seed=None)
    kept = np.unique(cells[:, :20])
    mesh_data = fem.build_mesh(
        points[kept], np.searchsorted(kept, cells[:, :20]), kind="hexahedron"
    )
    space = dolfinx.fem.functionspace(mesh_data.mesh, ("Lagrange", 2, (3,)))
    nodes = number_nodes(space, len(cells))
    np.testing.assert_array_equal(nodes.points[: len(kept)], points[kept])
    assert nodes.cell_type == "hexahedron27"
    # Edges are straight and mid nodes in the middle: so are the new ones of faces and cells.
    np.testing.assert_allclose(nodes.points[nodes.cells], points[cells], atol=1e-14)


def test_the_numbering_does_not_depend_on_the_order_of_the_cells() -> None:
    """The file's nodes keep their rows however DOLFINx orders the cells."""
    mesh = source("tetrahedron", cells=(6, 4, 4), seed=1)
    _, nodes = numbered(mesh, 1)
    np.testing.assert_array_equal(nodes.points, mesh.points)
    np.testing.assert_array_equal(nodes.cells, mesh.cells)
    np.testing.assert_array_equal(nodes.global_rows, nodes.rows)
