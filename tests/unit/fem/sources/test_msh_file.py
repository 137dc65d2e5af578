"""Gmsh's files: what Gmsh itself wrote is read back, in every version and encoding."""

import gmsh
import numpy as np
import pytest
from source_bodies import assert_mids_in_the_middle, corner_volume, group, write_two_boxes

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import read_source

KINDS = [("tetrahedron", 1), ("tetrahedron", 2), ("hexahedron", 1), ("hexahedron", 2)]


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_reads_what_gmsh_wrote(tmp_path, kind, order, version, binary):
    path = tmp_path / "two.msh"
    nodes = write_two_boxes(path, kind=kind, order=order, version=version, binary=binary)
    mesh = read_source(path)
    assert (mesh.kind, mesh.order) == (kind, order)
    assert mesh.cells.shape[1] == {1: 4, 2: 10}[order] if kind == "tetrahedron" else {1: 8, 2: 27}
    assert corner_volume(mesh) == pytest.approx(2.0, rel=1e-12)
    for number, point in zip(mesh.node_numbers, mesh.points, strict=True):
        np.testing.assert_allclose(point, nodes[int(number)], atol=1e-14)
    if order == 2:
        assert_mids_in_the_middle(mesh)


@pytest.mark.parametrize(("version", "save_all"), [(2.2, False), (4.1, False), (4.1, True)])
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize(("kind", "order"), KINDS)
def test_keeps_groups_of_every_dimension(tmp_path, kind, order, version, binary, save_all):
    path = tmp_path / "two.msh"
    write_two_boxes(path, kind=kind, order=order, version=version, binary=binary, save_all=save_all)
    mesh = read_source(path)
    left, right, everything = (group(mesh, name) for name in ("left", "right part", "all"))
    assert (left.number, right.number, everything.number) == (11, 12, 13)
    assert sorted([*left.entities, *right.entities]) == list(range(len(mesh.cells)))
    assert list(everything.entities) == list(range(len(mesh.cells)))
    centres = mesh.points[mesh.cells].mean(axis=1)
    assert np.all(centres[left.entities, 0] < 1.0)
    wall, end = group(mesh, "wall", 2), group(mesh, "7", 2)
    assert (wall.number, end.number) == (1, 7)
    assert wall.entities.shape[1] == (3 if kind == "tetrahedron" else 4)
    np.testing.assert_allclose(mesh.points[wall.entities][..., 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(mesh.points[end.entities][..., 0], 2.0, atol=1e-12)
    line, corner = group(mesh, "line", 1), group(mesh, "corner", 0)
    np.testing.assert_allclose(mesh.points[line.entities][..., :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(mesh.points[corner.entities], 0.0, atol=1e-12)
    rows = wall.entities if kind == "tetrahedron" else wall.entities[:, [0, 1, 2, 0, 2, 3]]
    x = mesh.points[rows.reshape(-1, 3)]
    areas = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2.0
    assert areas.sum() == pytest.approx(1.0)


def test_tells_that_format_2_lost_its_groups(tmp_path):
    path = tmp_path / "two.msh"
    write_two_boxes(path, version=2.2, save_all=True)
    mesh = read_source(path)
    assert mesh.groups == ()
    assert any("'wall'" in note and "SaveAll" in note for note in mesh.notes)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_completes_hexahedra_of_20_nodes(tmp_path, version):
    path = tmp_path / "two.msh"
    nodes = write_two_boxes(path, kind="hexahedron", order=2, version=version, incomplete=True)
    mesh = read_source(path)
    assert mesh.cells.shape[1] == 27
    assert_mids_in_the_middle(mesh)
    assert any("20 nodes" in note for note in mesh.notes)
    assert len(mesh.points) > len(nodes)
    assert len(np.unique(mesh.points.round(9), axis=0)) == len(mesh.points)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_reads_files_without_groups(tmp_path, version):
    path = tmp_path / "two.msh"
    write_two_boxes(path, version=version, groups=False)
    mesh = read_source(path)
    assert mesh.groups == ()
    assert corner_volume(mesh) == pytest.approx(2.0)


def test_keeps_the_order_of_the_file(tmp_path):
    path = tmp_path / "shuffled.msh"
    path.write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
        '$PhysicalNames\n1\n3 5 "my body"\n$EndPhysicalNames\n'
        "$Nodes\n5\n40 0 0 0\n7 1 0 0\n100 0 1 0\n3 0 0 1\n12 0 0 -1\n$EndNodes\n"
        "$Elements\n3\n9 4 2 5 1 40 7 100 3\n2 15 2 0 1 40\n5 4 2 5 1 40 100 7 12\n$EndElements\n"
    )
    mesh = read_source(path)
    assert mesh.node_numbers.tolist() == [40, 7, 100, 3, 12]
    assert mesh.cell_numbers.tolist() == [9, 5]
    assert mesh.cells.tolist() == [[0, 1, 2, 3], [0, 2, 1, 4]]
    assert group(mesh, "my body").entities.tolist() == [0, 1]


def test_leaves_a_session_of_gmsh_alone(tmp_path):
    path = tmp_path / "two.msh"
    write_two_boxes(path)
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        read_source(path)
        assert gmsh.isInitialized()
        assert gmsh.model.getCurrent() == "mine"
    finally:
        gmsh.finalize()


def test_joins_partitions(tmp_path):
    whole, parted = tmp_path / "whole.msh", tmp_path / "parted.msh"
    write_two_boxes(whole)
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(whole))
        gmsh.model.mesh.partition(3)
        gmsh.write(str(parted))
    finally:
        gmsh.finalize()
    a, b = read_source(whole), read_source(parted)
    assert len(a.cells) == len(b.cells)
    assert corner_volume(b) == pytest.approx(2.0)
    for name in ("left", "right part", "all", "wall"):
        assert len(group(a, name).entities) == len(group(b, name).entities)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello", ["begins with 'hello'", "$MeshFormat"]),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", ["$Nodes", "missing"]),
        ("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", ["version 4 ", "4.1", "gmsh FILE"]),
        ("$MeshFormat\n1.0\n$EndMeshFormat\n", ["$MeshFormat", "version"]),
        ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n", ["$Nodes", "not closed"]),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n$EndNodes\n",
            ["$Nodes", "ends too early"],
        ),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 zero 0\n$EndNodes\n",
            ["'zero'", "number is expected"],
        ),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n"
            "$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n",
            ["refers to node 2", "not define"],
        ),
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n"
            "$Elements\n1\n1 77 0 1 2 3 4\n$EndElements\n",
            ["type 77", "tetrahedra"],
        ),
    ],
)
def test_names_what_is_wrong(tmp_path, text, words):
    path = tmp_path / "bad.msh"
    path.write_text(text)
    with pytest.raises(MeshError) as error:
        read_source(path)
    for word in [str(path), *words]:
        assert word in str(error.value)
