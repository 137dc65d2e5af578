"""Vega's files: numbering, includes, sets, materials, regions, and what is refused."""

import numpy as np
import pytest
from source_bodies import corner_volume, group, hex_box, tet_box

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import read_source

MATERIAL = "*MATERIAL steel\nENU, 7800, 2e11, 0.3\n*REGION\nallElements, steel\n"


def mesh_text(points, cells, *, base=1, comma=" "):
    kind = {4: "TET", 8: "CUBIC"}[cells.shape[1]]
    vertices = "\n".join(
        comma.join(map(str, (i + base, *point))) for i, point in enumerate(points.tolist())
    )
    elements = "\n".join(
        comma.join(map(str, (i + base, *row))) for i, row in enumerate((cells + base).tolist())
    )
    return (
        f"# a comment\n\n*VERTICES\n{len(points)} 3 0 0\n{vertices}\n\n"
        f"*ELEMENTS\n{kind}\n# another\n{len(cells)} {cells.shape[1]} 0\n{elements}\n\n"
    )


def one_tet(extra="", **options):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return mesh_text(points, np.array([[0, 1, 2, 3]]), **options) + extra


@pytest.mark.parametrize("comma", [" ", ", ", "\t"])
@pytest.mark.parametrize("base", [0, 1])
@pytest.mark.parametrize("make", [tet_box, hex_box])
def test_geometry_comes_back(tmp_path, make, base, comma):
    points, cells = make(2, (1.0, 2.0, 3.0))
    path = tmp_path / "box.veg"
    path.write_text(mesh_text(points, cells, base=base, comma=comma) + MATERIAL)
    mesh = read_source(path)
    np.testing.assert_array_equal(mesh.points, points)
    np.testing.assert_array_equal(mesh.cells, cells)
    assert corner_volume(mesh) == pytest.approx(6.0)
    assert mesh.node_numbers.tolist() == list(range(1, len(points) + 1))
    assert group(mesh, "allElements").entities.tolist() == list(range(len(cells)))
    assert any("from 0" in note for note in mesh.notes) == (base == 0)
    (material,) = mesh.materials
    assert (material.region, material.law) == (None, "st-venant-kirchhoff")
    assert material.constants == {"young": 2e11, "poisson": 0.3, "density": 7800.0}


@pytest.mark.parametrize("base", [0, 1])
def test_sets_and_regions_in_included_files(tmp_path, base):
    points, cells = tet_box(1)
    (tmp_path / "deep").mkdir()
    (tmp_path / "sets.txt").write_text("*SET head\n*INCLUDE deep/head.txt\n")
    (tmp_path / "deep" / "head.txt").write_text(
        f"{base}, {1 + base},\n, {2 + base},\n*INCLUDE more.txt\n"
    )
    (tmp_path / "deep" / "more.txt").write_text(f"{4 + base}\n")
    path = tmp_path / "box.veg"
    path.write_text(
        mesh_text(points, cells, base=base)
        + "*INCLUDE sets.txt\n*MATERIAL soft\nENU, 1000, 1e5, 0.4\n"
        + "*MATERIAL rubber\nMOONEYRIVLIN, 1100, 20, 80, 500\n"
        + "*REGION\nallElements, soft\n*REGION\nhead, rubber\n"
    )
    mesh = read_source(path)
    assert group(mesh, "head").entities.tolist() == [0, 1, 2, 4]
    assert group(mesh, "head").number == 1
    soft, rubber = mesh.materials
    assert (soft.region, rubber.region) == (None, "head")
    assert rubber.law == "mooney-rivlin"
    # Vega: mu10 (I1 - 3) + mu01 (I2 - 3) + v1 (J - 1)^2, given as density, mu01, mu10, v1.
    assert rubber.constants == {"c01": 20.0, "c10": 80.0, "bulk": 1000.0, "density": 1100.0}


def test_a_file_without_materials_is_a_mesh(tmp_path):
    path = tmp_path / "box.veg"
    path.write_text(one_tet())
    assert read_source(path).materials == ()


BAD = {
    "missing include": ("*INCLUDE gone.txt\n", ["'gone.txt'", "does not exist"]),
    "circle": ("*INCLUDE box.veg\n", ["'box.veg'", "circle"]),
    "orthotropic": (
        "*MATERIAL bone\nORTHOTROPIC_N1, 1, 2, 3, 4, 0.3\n",
        ["'bone'", "ORTHOTROPIC_N1", "ENU"],
    ),
    "unknown section": ("*SPRINGS\n1 2\n", ["*SPRINGS", "allowed are", "*REGION"]),
    "unknown material": ("*REGION\nallElements, gold\n", ["'gold'", "none"]),
    "unknown set": (MATERIAL + "*REGION\ntail, steel\n", ["'tail'", "'allElements'"]),
    "uncovered": (
        "*SET none\n\n*MATERIAL m\nENU, 1, 1, 0.3\n*REGION\nnone, m\n",
        ["1 of 1 cells", "no material", "cell 1"],
    ),
    "set out of range": ("*SET big\n1, 2\n", ["element 2", "1 to 1"]),
    "set of words": ("*SET big\n1, two\n", ["'two'", "number"]),
    "too few constants": ("*MATERIAL m\nENU, 1, 1\n", ["density, E, nu"]),
    "two vertices sections": ("*VERTICES\n1 3 0 0\n1 0 0 0\n", ["2 sections *VERTICES"]),
}


@pytest.mark.parametrize("case", BAD)
def test_names_what_is_wrong(tmp_path, case):
    extra, words = BAD[case]
    path = tmp_path / "box.veg"
    path.write_text(one_tet(extra))
    with pytest.raises(MeshError) as error:
        read_source(path)
    for word in [str(path), *words]:
        assert word in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("4 3 0 0", "5 3 0 0", ["announces 5 rows", "4 rows"]),
        ("4 3 0 0", "many", ["'many'"]),
        ("TET", "PRISM", ["'PRISM'", "TET and CUBIC"]),
        ("1 1 2 3 4", "1 1 2 3 9", ["node row 8", "0 to 3"]),
        ("1 1 2 3 4", "1 1 2 3 3", ["same node twice", "cell 1"]),
        ("4 0.0 0.0 1.0", "4 0.0 0.0 nan", ["not finite", "node 4"]),
        ("4 0.0 0.0 1.0", "7 0.0 0.0 1.0", ["row 4 has number 7"]),
        ("4 0.0 0.0 1.0", "4 0.3 0.3 0.0", ["no volume", "cell 1 at"]),
        ("*ELEMENTS", "*ELEMENT", ["*ELEMENT", "not a section"]),
    ],
)
def test_names_damage_of_the_mesh(tmp_path, old, new, words):
    path = tmp_path / "box.veg"
    text = one_tet()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(MeshError) as error:
        read_source(path)
    for word in [str(path), *words]:
        assert word in str(error.value)
