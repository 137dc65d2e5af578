"""Selections on a mesh: which nodes and entities a text means."""

from pathlib import Path

import basix.ufl
import gmsh
import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.errors import SelectionError
from fenics_defo.fem.compat import MPI, dolfinx
from fenics_defo.fem.imported import MeshData, mesh_record
from fenics_defo.fem.nodes import NodeNumbering, number_nodes
from fenics_defo.fem.regions import select_nodes
from tests.unit.fem.fem_bodies import KINDS, SIDES, mesh_of, source, tapered, usual_groups

Space = tuple["dolfinx.fem.FunctionSpace", NodeNumbering]
Bools = NDArray[np.bool_]

CASES = [(k, o, m) for k in KINDS for o in (1, 2) for m in (1, 2)]


def space_on(mesh_data: MeshData, order: int) -> Space:
    space = dolfinx.fem.functionspace(mesh_data.mesh, ("Lagrange", order, (3,)))
    return space, number_nodes(space, mesh_data.mesh.topology.index_map(3).size_global)


def body(kind: str, order: int, mesh_order: int) -> tuple[MeshData, Space]:
    mesh_data = mesh_of(source(kind, order=mesh_order, groups=usual_groups(kind)))
    return mesh_data, space_on(mesh_data, order)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
@pytest.mark.parametrize(
    "selection",
    ["root", 7, "7", "pins", "4", "x<1e-6", "x == 0", "nodes:FILE", "'root'"],
)
def test_all_ways_to_name_one_face(
    kind: str, order: int, mesh_order: int, selection: str | int, tmp_path: Path
) -> None:
    """Facets, their nodes, a comparison and a file of numbers mean the same nodes at any order."""
    mesh_data, (space, numbering) = body(kind, order, mesh_order)
    x = numbering.points[:, 0]
    if selection == "nodes:FILE":
        path = tmp_path / "root.bou"
        rows = np.flatnonzero(x[: numbering.file_nodes] < 1e-9)
        path.write_text(",".join(map(str, mesh_data.record.node_numbers[rows])))
        selection = f"nodes:{path}"
    chosen = select_nodes(mesh_data, space, numbering, selection)
    np.testing.assert_array_equal(chosen, (x < 1e-9) & numbering.carried)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CASES)
def test_edges_and_volumes_mean_all_their_nodes(kind: str, order: int, mesh_order: int) -> None:
    mesh_data, (space, numbering) = body(kind, order, mesh_order)
    x, _, z = numbering.points.T
    edge = select_nodes(mesh_data, space, numbering, "9")
    np.testing.assert_array_equal(edge, (x < 1e-9) & (z < 1e-9) & numbering.carried)
    left = select_nodes(mesh_data, space, numbering, "left")
    np.testing.assert_array_equal(left, (x < SIDES[0] / 3 + 1e-9) & numbering.carried)


@pytest.mark.parametrize("kind", KINDS)
def test_entities(kind: str) -> None:
    mesh_data = mesh_of(source(kind, groups=usual_groups(kind), mapping=tapered))
    mesh, record = mesh_data.mesh, mesh_data.record

    def middles(selection: str | int, dimension: int) -> NDArray[np.float64]:
        found = fem.select_entities(mesh_data, selection, dimension=dimension)
        assert found.dtype == np.int32
        assert (np.diff(found) > 0).all()
        return dolfinx.mesh.compute_midpoints(mesh, dimension, found)

    for name, number in [("left", 1), ("right", 2), ("middle", 5)]:
        np.testing.assert_array_equal(middles(name, 3), middles(number, 3))
        (size,) = (g.size for g in record.groups if g.name == name)
        assert len(middles(name, 3)) == size
    facets = 4 if kind == "tetrahedron" else 2
    for selection in ("root", 7, "x<1e-6"):
        assert len(middles(selection, 2)) == facets
        np.testing.assert_allclose(middles(selection, 2)[:, 0], 0.0, atol=1e-12)
    third = SIDES[0] / 3.0
    np.testing.assert_array_equal(middles("left", 3), middles(f"x < {third}", 3))
    assert len(middles("x<1e-6", 0)) == 6
    assert len(middles("pins", 0)) == 6
    assert len(middles("9", 1)) == 2


def test_a_node_file_gives_the_facets_between_its_nodes(tmp_path: Path) -> None:
    mesh = source("tetrahedron", groups=usual_groups("tetrahedron"))
    mesh_data = mesh_of(mesh)
    path = tmp_path / "root.txt"
    path.write_text("\n".join(map(str, 1 + np.flatnonzero(mesh.points[:, 0] < 1e-9))))
    by_file = fem.select_entities(mesh_data, f"nodes:{path}", dimension=2)
    np.testing.assert_array_equal(by_file, fem.select_entities(mesh_data, "root", dimension=2))


@pytest.mark.parametrize(
    ("selection", "problem"),
    [
        ("Root", "no group 'Root'"),
        (70, "no group 70"),
        ("x>5", "'x>5' matches no node"),
        ("nodes:FILE", "no node 99"),
        ("x<", "x<"),
    ],
)
def test_an_empty_selection_says_what_there_is(
    selection: str | int, problem: str, tmp_path: Path
) -> None:
    mesh_data, (space, numbering) = body("tetrahedron", 1, 1)
    if selection == "nodes:FILE":
        (tmp_path / "a.bou").write_text("1, 99, 100")
        selection = f"nodes:{tmp_path / 'a.bou'}"
    with pytest.raises(SelectionError) as caught:
        select_nodes(mesh_data, space, numbering, selection)
    message = str(caught.value)
    assert problem in message
    if problem.startswith("no group") or "matches" in problem:
        for known in ("'left' (1,", "'root' (7, 4 facets)", "'9' (9, 2 edges)", "'pins' (4,"):
            assert known in message


def test_a_group_of_another_dimension_is_no_region() -> None:
    mesh_data, _ = body("hexahedron", 1, 1)
    with pytest.raises(SelectionError, match=r"'root' matches no volume.*'root' \(7, 2 facets\)"):
        fem.select_entities(mesh_data, "root", dimension=3)


def test_a_mesh_without_groups_says_so() -> None:
    mesh_data = mesh_of(source("tetrahedron"))
    with pytest.raises(SelectionError, match="no groups at all"):
        fem.select_entities(mesh_data, "root", dimension=2)


@pytest.fixture(scope="module")
def cylinder() -> MeshData:
    """DOLFINx's own reading of a quarter of a ring; one of its faces has a number only."""
    gmsh.initialize(["gmsh", "-v", "0"], interruptible=False)
    geo = gmsh.model.geo
    p = [geo.addPoint(*xy, 0.0, 1.0) for xy in [(1, 0), (2, 0), (0, 2), (0, 1), (0, 0)]]
    outline = [
        geo.addLine(p[0], p[1]),
        geo.addCircleArc(p[1], p[4], p[2]),
        geo.addLine(p[2], p[3]),
        geo.addCircleArc(p[3], p[4], p[0]),
    ]
    face = geo.addPlaneSurface([geo.addCurveLoop(outline)])
    swept = geo.extrude([(2, face)], 0, 0, 1.0)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [swept[1][1]], 3, "body")
    gmsh.model.addPhysicalGroup(2, [face], 4, "end")
    gmsh.model.addPhysicalGroup(2, [swept[3][1]], 3)
    gmsh.model.addPhysicalGroup(1, [outline[1]], 11, "rim")
    gmsh.model.mesh.generate(3)
    mesh_data = dolfinx.io.gmsh.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0)
    gmsh.finalize()
    return mesh_data


@pytest.mark.parametrize("order", [1, 2])
def test_the_groups_of_dolfinx_own_reader(cylinder: MeshData, order: int) -> None:
    space, numbering = space_on(cylinder, order)
    x, y, z = numbering.points.T
    chosen = select_nodes(cylinder, space, numbering, "end")
    np.testing.assert_array_equal(chosen, z < 1e-9)
    np.testing.assert_array_equal(select_nodes(cylinder, space, numbering, "4"), chosen)
    rim = select_nodes(cylinder, space, numbering, "rim")
    outer = np.hypot(x, y) > (2.0 - 1e-9 if order == 1 else 1.9)  # chords of eight arcs
    np.testing.assert_array_equal(rim, outer & chosen)


def with_lonely_nodes() -> MeshData:
    """A mesh whose input had nodes of no cell among the others, which DOLFINx drops."""
    mesh = source("tetrahedron")
    points = np.insert(mesh.points, [0, 5, 5], 50.0, axis=0)
    rows = np.setdiff1d(np.arange(len(points)), [0, 6, 7])
    element = basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,))
    domain = dolfinx.mesh.create_mesh(MPI.COMM_SELF, rows[mesh.cells], element, points)
    return MeshData(domain, None, None, None, None, {})


@pytest.mark.parametrize("order", [1, 2])
def test_a_foreign_mesh_with_nodes_of_no_cell(order: int, tmp_path: Path) -> None:
    mesh, mesh_data = source("tetrahedron"), with_lonely_nodes()
    record = mesh_record(mesh_data)
    n = len(mesh.points)
    assert record.node_numbers.tolist() == [*range(2, 7), *range(9, n + 4)]
    space, numbering = space_on(mesh_data, order)
    np.testing.assert_array_equal(numbering.points[:n], mesh.points)
    np.testing.assert_array_equal(numbering.cells[:, :4], mesh.cells)
    (tmp_path / "one.txt").write_text(str(record.node_numbers[5]))
    chosen = select_nodes(mesh_data, space, numbering, f"nodes:{tmp_path / 'one.txt'}")
    np.testing.assert_array_equal(np.flatnonzero(chosen), [5])
    root = record.node_numbers[mesh.points[:, 0] < 1e-9]
    (tmp_path / "root.txt").write_text(" ".join(map(str, root)))
    found = fem.select_entities(mesh_data, f"nodes:{tmp_path / 'root.txt'}", dimension=2)
    np.testing.assert_array_equal(found, fem.select_entities(mesh_data, "x<1e-6", dimension=2))


def test_one_number_at_two_dimensions(cylinder: MeshData) -> None:
    """Physical tags are counted for each dimension: 3 is the body, and a face without a name."""
    groups = {(g.name, g.number, g.dimension) for g in mesh_record(cylinder).groups}
    assert groups == {("body", 3, 3), ("end", 4, 2), ("3", 3, 2), ("rim", 11, 1)}
    cells = fem.select_entities(cylinder, 3, dimension=3)
    assert len(cells) == cylinder.mesh.topology.index_map(3).size_local
    assert len(fem.select_entities(cylinder, 3, dimension=2)) > 0
    np.testing.assert_array_equal(cells, fem.select_entities(cylinder, "body", dimension=3))


def test_a_submesh_counts_in_its_own_order() -> None:
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, [[0, 0, 0], [1, 1, 1]], [4, 2, 2])
    left = dolfinx.mesh.locate_entities(mesh, 3, lambda x: x[0] <= 0.5)
    part = dolfinx.mesh.create_submesh(mesh, 3, left)[0]
    mesh_data = MeshData(part, None, None, None, None, {})
    space, numbering = space_on(mesh_data, 2)
    np.testing.assert_allclose(
        space.tabulate_dof_coordinates(), numbering.points[numbering.rows], atol=1e-14
    )
    assert len(numbering.cells) == len(left)
    assert select_nodes(mesh_data, space, numbering, "x==0.5").sum() == 25
