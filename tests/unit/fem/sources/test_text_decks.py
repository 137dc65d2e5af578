"""Abaqus decks and TetGen pairs."""

import numpy as np
import pytest
from source_bodies import assert_mids_in_the_middle, body, corner_volume, group

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import read_source

TYPES = {4: "C3D4", 10: "C3D10M", 8: "c3d8r", 20: "C3D20R"}


def deck(points, cells, *, extra="", step=10):
    """Nodes 10, 20, ..., elements 101, 102, ...; long rows are continued on a second line."""
    nodes = "\n".join(
        f"{step * (i + 1)}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(points.tolist())
    )
    rows = []
    for i, row in enumerate((step * (cells + 1)).tolist()):
        words = [str(101 + i), *map(str, row)]
        rows.append(", ".join(words[:16]) + (",\n" + ", ".join(words[16:]) if words[16:] else ""))
    return (
        f"*Heading\n** a comment, 1, 2\n*Node\n{nodes}\n"
        f"*Element, type={TYPES[cells.shape[1]]}, elset=Body\n" + "\n".join(rows) + "\n" + extra
    )


@pytest.mark.parametrize("nodes", [4, 10, 8, 20])
def test_deck_comes_back(tmp_path, nodes):
    kind = "tetrahedron" if nodes in (4, 10) else "hexahedron"
    points, cells = body(kind, nodes, size=(1.0, 2.0, 3.0))
    path = tmp_path / "box.inp"
    path.write_text(deck(points, cells))
    mesh = read_source(path)
    assert corner_volume(mesh) == pytest.approx(6.0)
    assert mesh.node_numbers[: len(points)].tolist() == [10 * (i + 1) for i in range(len(points))]
    assert mesh.cell_numbers.tolist() == [101 + i for i in range(len(cells))]
    np.testing.assert_array_equal(mesh.cells[:, :nodes], cells)
    assert group(mesh, "Body").entities.tolist() == list(range(len(cells)))
    if mesh.order == 2:
        assert_mids_in_the_middle(mesh)


def test_sets_and_surfaces_become_groups(tmp_path):
    points, cells = body("hexahedron", 8, n=1)
    extra = (
        "*Nset, nset=Bottom\n10, 20, 30,\n40\n*NSET, NSET=both\nbottom, 50\n"
        "*Elset, elset=Some, generate\n101, 101, 1\n"
        "*Surface, type=ELEMENT, name=Top\nSome, S2\n*Material, name=steel\n*Elastic\n2e11, 0.3\n"
    )
    path = tmp_path / "box.inp"
    path.write_text(deck(points, cells, extra=extra))
    mesh = read_source(path)
    np.testing.assert_array_equal(mesh.points[group(mesh, "Bottom").entities[:, 0], 2], 0.0)
    assert len(group(mesh, "both").entities) == 5
    assert group(mesh, "Some", 3).entities.tolist() == [0]
    top = group(mesh, "Top")
    assert top.dimension == 2
    np.testing.assert_array_equal(mesh.points[top.entities[0], 2], 1.0)
    assert len({g.number for g in mesh.groups}) == len(mesh.groups)


@pytest.mark.parametrize(("face", "axis", "value"), [
    ("S1", 2, 0.0), ("S2", 2, 1.0), ("S3", 1, 0.0), ("S4", 0, 1.0), ("S5", 1, 1.0), ("S6", 0, 0.0),
])  # fmt: skip
def test_faces_of_the_hexahedron(tmp_path, face, axis, value):
    points, cells = body("hexahedron", 8, n=1)
    path = tmp_path / "box.inp"
    path.write_text(deck(points, cells, extra=f"*SURFACE, NAME=side\n101, {face}\n"))
    mesh = read_source(path)
    np.testing.assert_array_equal(mesh.points[group(mesh, "side").entities[0], axis], value)


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        ("*Nset, nset=a\n5\n", ["'a'", "node 5"]),
        ("*Elset, elset=a\nother\n", ["'other'", "define that set"]),
        ("*Elset, elset=a\n5\n", ["'a'", "1 elements"]),
        ("*Element, type=C3D27\n1, 1\n", ["'C3D27'", "C3D20"]),
        ("*Element, type=C3D4\n1, 10, 20\n", ["not a multiple of 5"]),
        ("*Element, type=C3D4\n900, 10, 20, 30, 77\n", ["node 77"]),
        ("*Element, type=C3D4\n900, 10, 20, 30, 50\n", ["8 of type hexahedron", "1 of type tetra"]),
        ("*Surface, name=a\nBody, SPOS\n", ["'SPOS'", "S1 to S6"]),
        ("*Instance, name=a, part=b\n1., 0., 0.\n*End Instance\n", ["assembly", "flat mesh"]),
        ("*INCLUDE, INPUT=gone.inp\n", ["'gone.inp'", "does not exist"]),
    ],
)
def test_deck_names_what_is_wrong(tmp_path, extra, words):
    points, cells = body("hexahedron", 8)
    path = tmp_path / "box.inp"
    path.write_text(deck(points, cells, extra=extra))
    with pytest.raises(MeshError) as error:
        read_source(path)
    for word in [str(path), *words]:
        assert word in str(error.value)


def tetgen(folder, points, cells, *, base, regions=None, order=range(10)):
    nodes = "\n".join(
        f"{i + base} {x} {y} {z} {int(z == 0)}" for i, (x, y, z) in enumerate(points.tolist())
    )
    (folder / "box.node").write_text(f"# made\n{len(points)} 3 0 1\n{nodes}\n# end\n")
    columns = [c for c in order if c < cells.shape[1]]
    rows = [[i + base, *row] for i, row in enumerate((cells[:, columns] + base).tolist())]
    if regions is not None:
        rows = [[*row, region] for row, region in zip(rows, regions, strict=True)]
    text = "\n".join(" ".join(map(str, row)) for row in rows)
    (folder / "box.ele").write_text(
        f"{len(cells)} {cells.shape[1]} {int(regions is not None)}\n{text}\n"
    )


@pytest.mark.parametrize("suffix", [".node", ".ele"])
@pytest.mark.parametrize("base", [0, 1])
@pytest.mark.parametrize("nodes", [4, 10])
def test_tetgen_pair_comes_back(tmp_path, suffix, base, nodes):
    points, cells = body("tetrahedron", nodes)
    regions = 1 + np.arange(len(cells)) % 2
    # Any order of the mid nodes is recognised by where they are.
    order = [0, 1, 2, 3, 6, 7, 9, 5, 8, 4]
    tetgen(tmp_path, points, cells, base=base, regions=regions, order=order)
    mesh = read_source(tmp_path / f"box{suffix}")
    np.testing.assert_array_equal(mesh.points, points)
    np.testing.assert_array_equal(mesh.cells, cells)
    assert mesh.node_numbers[0] == 1
    assert group(mesh, "2", 3).entities.tolist() == np.flatnonzero(regions == 2).tolist()
    np.testing.assert_array_equal(mesh.points[group(mesh, "1", 0).entities[:, 0], 2], 0.0)


def test_tetgen_needs_both_files(tmp_path):
    points, cells = body("tetrahedron", 4)
    tetgen(tmp_path, points, cells, base=0)
    (tmp_path / "box.node").unlink()
    with pytest.raises(MeshError, match=r"box\.node is missing"):
        read_source(tmp_path / "box.ele")
