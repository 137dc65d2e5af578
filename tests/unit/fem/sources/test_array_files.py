"""Formats read through meshio: geometry, node order and groups come back."""

import meshio
import numpy as np
import pytest
from source_bodies import assert_mids_in_the_middle, body, corner_volume, group, tet_box

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import read_source

CELLS = {
    ("tetrahedron", 4): "tetra",
    ("tetrahedron", 10): "tetra10",
    ("hexahedron", 8): "hexahedron",
    ("hexahedron", 20): "hexahedron20",
    ("hexahedron", 27): "hexahedron27",
}


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".xdmf"])
@pytest.mark.parametrize(("kind", "nodes"), list(CELLS))
def test_geometry_comes_back(tmp_path, suffix, kind, nodes):
    points, cells = body(kind, nodes, size=(1.0, 2.0, 3.0))
    path = tmp_path / f"box{suffix}"
    meshio.Mesh(points, [(CELLS[kind, nodes], cells)]).write(path)
    mesh = read_source(path)
    assert mesh.kind == kind
    assert corner_volume(mesh) == pytest.approx(6.0)
    np.testing.assert_array_equal(mesh.points[: len(points)], points)
    np.testing.assert_array_equal(mesh.cells[:, :nodes], cells)
    assert mesh.node_numbers.tolist() == list(range(1, len(mesh.points) + 1))
    if mesh.order == 2:
        assert_mids_in_the_middle(mesh)


@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
def test_medit_references_become_groups(tmp_path, kind):
    points, cells = body(kind, 4 if kind == "tetrahedron" else 8)
    left = (points[cells][..., 0].mean(axis=1) < 0.5).astype(int)
    path = tmp_path / "box.mesh"
    cell_type = CELLS[kind, cells.shape[1]]
    facets = {"tetrahedron": ("triangle", 3), "hexahedron": ("quad", 4)}[kind]
    wall = cells[:1, :3] if kind == "tetrahedron" else cells[:1, :4]
    meshio.Mesh(
        points,
        [(cell_type, cells), (facets[0], wall)],
        cell_data={"medit:ref": [2 + left, np.array([9])]},
    ).write(path)
    mesh = read_source(path)
    assert {(g.name, g.number, g.dimension) for g in mesh.groups} == {
        ("2", 2, 3), ("3", 3, 3), ("9", 9, 2),
    }  # fmt: skip
    assert group(mesh, "3").entities.tolist() == np.flatnonzero(left).tolist()
    assert sorted(group(mesh, "9").entities[0]) == sorted(wall[0])


def test_integer_arrays_and_sets_become_groups(tmp_path):
    points, cells = tet_box()
    region = np.arange(len(cells)) % 2
    path = tmp_path / "box.vtu"
    data = {"part": [region], "stress": [np.ones(len(cells))]}
    meshio.Mesh(points, [("tetra", cells)], cell_data=data).write(path)
    mesh = read_source(path)
    assert [(g.name, g.number) for g in mesh.groups] == [("0", 0), ("1", 1)]
    assert group(mesh, "1").entities.tolist() == np.flatnonzero(region).tolist()


def test_an_array_that_numbers_the_cells_is_no_group(tmp_path):
    points, cells = tet_box(6)
    path = tmp_path / "box.vtu"
    meshio.Mesh(points, [("tetra", cells)], cell_data={"id": [np.arange(len(cells))]}).write(path)
    assert read_source(path).groups == ()


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".xdmf", ".mesh"])
def test_a_file_of_other_content_is_one_sentence(tmp_path, suffix):
    path = tmp_path / f"picture{suffix}"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    with pytest.raises(MeshError) as error:
        read_source(path)
    assert str(path) in str(error.value)
    assert "Traceback" not in str(error.value)
    assert len(str(error.value)) < 400 + 2 * len(str(path))


def test_a_medit_file_without_cells_is_no_mesh(tmp_path):
    """Meshio writes one for second-order tetrahedra, which it leaves out."""
    path = tmp_path / "empty.mesh"
    path.write_text("MeshVersionFormatted 2\nDimension\n3\nVertices\n1\n0 0 0 1\nEnd\n")
    with pytest.raises(MeshError, match=r"empty\.mesh"):
        read_source(path)


def test_second_order_medit_files_are_sent_elsewhere(tmp_path):
    path = tmp_path / "curved.mesh"
    path.write_text(
        "MeshVersionFormatted 2\nDimension\n3\nVertices\n1\n0 0 0 1\n"
        "TetrahedraP2\n1\n1 1 1 1 1 1 1 1 1 1 1\nEnd\n"
    )
    with pytest.raises(MeshError, match=r"second-order.*\.msh or \.vtu"):
        read_source(path)
