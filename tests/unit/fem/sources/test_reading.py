"""The door: what can be wrong with a path, and damaged files of every format."""

import contextlib
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from source_bodies import body, tet_box, write_two_boxes

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import read_source
from fenics_defo.fem.sources.reading import FILLERS, LENGTH_UNITS, READERS


def refused(path, **options):
    with pytest.raises(MeshError) as error:
        read_source(path, **options)
    text = str(error.value)
    assert "\n" not in text
    return text


def test_paths_that_are_no_file(tmp_path):
    assert "does not exist" in refused(tmp_path / "gone.msh")
    assert "is a directory" in refused(tmp_path)
    (tmp_path / "nil.msh").touch()
    assert "is empty" in refused(tmp_path / "nil.msh")
    assert "does not exist" in refused("bad\0name.msh")
    assert "cannot be opened" in refused("x" * 5000 + ".msh")


@pytest.mark.parametrize("name", ["mesh.txt", "mesh", "mesh.msh.gz"])
def test_unknown_suffixes_list_the_known_ones(tmp_path, name):
    (tmp_path / name).write_text("something")
    text = refused(tmp_path / name)
    for suffix in (*READERS, *FILLERS):
        assert suffix in text


def test_capital_suffixes_and_strings_are_accepted(tmp_path):
    points, cells = tet_box(1)
    meshio.Mesh(points, [("tetra", cells)]).write(tmp_path / "box.vtu")
    (tmp_path / "box.vtu").rename(tmp_path / "BOX.VTU")
    mesh = read_source(str(tmp_path / "BOX.VTU"))
    assert mesh.path == tmp_path / "BOX.VTU"


@pytest.mark.parametrize("suffix", [*READERS, *FILLERS])
def test_files_of_other_content(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    (tmp_path / "mesh.node").write_text("x")
    (tmp_path / "mesh.ele").write_text("x")
    for content in (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(range(256)), b"hello world\n", b"\n"):
        path.write_bytes(content)
        text = refused(path, size=0.1)
        assert str(path.with_suffix("")) in text
        assert "Traceback" not in text


@pytest.mark.parametrize("size", [0.0, -1.0, np.nan, np.inf, "small", True])
def test_size_must_be_a_length(tmp_path, size):
    path = tmp_path / "a.stl"
    path.write_text("solid\n")
    assert "--size (size=) must be a positive length" in refused(path, size=size)


def test_size_is_noted_where_it_is_not_used(tmp_path):
    points, cells = tet_box(1)
    meshio.Mesh(points, [("tetra", cells)]).write(tmp_path / "box.vtu")
    mesh = read_source(tmp_path / "box.vtu", size=0.1)
    assert any("size is not used" in note for note in mesh.notes)


def test_surface_meshes_are_refused_with_a_remedy(tmp_path):
    points, cells = tet_box(1)
    meshio.Mesh(points, [("triangle", cells[:, :3])]).write(tmp_path / "skin.vtk", binary=False)
    text = refused(tmp_path / "skin.vtk")
    assert "6 cells of type triangle" in text
    assert ".stl" in text
    assert "--size" in text


def test_mixed_cells_are_refused_with_counts(tmp_path):
    points, hexes = body("hexahedron", 8)
    cells = [
        ("hexahedron", hexes[:6]),
        ("wedge", hexes[6:7][:, [0, 1, 3, 4, 5, 7]]),
        ("pyramid", hexes[7:][:, :5]),
    ]
    meshio.Mesh(points, cells).write(tmp_path / "mixed.vtu")
    text = refused(tmp_path / "mixed.vtu")
    for words in ("6 of type hexahedron", "1 of type wedge", "1 of type pyramid"):
        assert words in text


def test_facets_off_the_body_are_dropped_and_noted(tmp_path):
    points, cells = tet_box(1)
    triangles = np.array([[0, 2, 1], [0, 3, 5]])  # the second crosses the box
    path = tmp_path / "box.vtu"
    data = {"gmsh:physical": [np.ones(len(cells), int), np.array([8, 8])]}
    meshio.Mesh(points, [("tetra", cells), ("triangle", triangles)], cell_data=data).write(path)
    mesh = read_source(path)
    facets = [g for g in mesh.groups if g.dimension == 2]
    on_body = sum(len(g.entities) for g in facets)
    lost = [note for note in mesh.notes if "not on any volume" in note]
    assert on_body + int(lost[0].split()[0] if lost else 0) == 2
    assert lost


@pytest.fixture(scope="module")
def samples(tmp_path_factory) -> dict[str, Path]:
    """One sound file of each format that is read without filling."""
    folder = tmp_path_factory.mktemp("samples")
    points, cells = tet_box(2)
    references = {"medit:ref": [np.arange(len(cells)) % 2 + 1]}
    mesh = meshio.Mesh(points, [("tetra", cells)], cell_data=references)
    for name in ("a.vtu", "a.vtk", "a.xdmf", "a.mesh"):
        mesh.write(folder / name)
    mesh.write(folder / "text.vtu", binary=False)
    meshio.Mesh(points, [("tetra", cells)]).write(folder / "a.inp")
    meshio.Mesh(points, [("tetra", cells)]).write(folder / "a.ele")
    for version in (2.2, 4.1):
        for binary in (False, True):
            write_two_boxes(folder / f"v{version}-{binary}.msh", version=version, binary=binary)
    rows = [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points, start=1)]
    tets = [f"{i} " + " ".join(map(str, row + 1)) for i, row in enumerate(cells, start=1)]
    (folder / "a.veg").write_text(
        "\n".join(
            [f"*VERTICES\n{len(rows)} 3 0 0", *rows, f"*ELEMENTS\nTET\n{len(tets)} 4 0", *tets]
        )
        + "\n*MATERIAL m\nENU, 1000, 1e6, 0.3\n*REGION\nallElements, m\n"
    )
    return {path.name: path for path in folder.iterdir() if path.suffix not in (".h5", ".node")}


@settings(max_examples=250, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_damaged_files_raise_nothing_but_a_sentence(samples, data):
    path = samples[data.draw(st.sampled_from(sorted(samples)))]
    content = path.read_bytes()
    cut = data.draw(st.integers(1, len(content)))
    spoiled = bytearray(content[:cut])
    for _ in range(data.draw(st.integers(0, 3))):
        place = data.draw(st.integers(0, cut - 1))
        spoiled[place] = data.draw(st.integers(0, 255))
    damaged = path.with_name("damaged" + path.suffix)
    damaged.write_bytes(spoiled)
    if path.suffix == ".ele":
        damaged.with_suffix(".node").write_bytes(path.with_suffix(".node").read_bytes())
    with contextlib.suppress(MeshError):  # and no other error
        mesh = read_source(damaged)
        assert np.isfinite(mesh.points).all()
        assert mesh.cells.max() < len(mesh.points)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_files_cut_off_are_not_taken_for_whole(samples, share):
    for path in samples.values():
        content = path.read_bytes()
        cut = path.with_name("cut" + path.suffix)
        cut.write_bytes(content[: int(share * len(content))])
        if path.suffix == ".ele":
            cut.with_suffix(".node").write_bytes(path.with_suffix(".node").read_bytes())
        if path.suffix in (".inp", ".xdmf") and share == 0.9:
            continue  # a deck may end after any line; the numbers of .xdmf are in another file
        refused(cut)


@pytest.mark.parametrize("unit", [*LENGTH_UNITS])
def test_a_files_unit_scales_its_points(tmp_path, unit):
    points, cells = tet_box(2)
    meshio.Mesh(points, [("tetra", cells)]).write(tmp_path / "box.vtu")
    mesh = read_source(tmp_path / "box.vtu", unit=unit)
    assert mesh.points == pytest.approx(LENGTH_UNITS[unit] * points, rel=1e-15)


def test_an_unknown_unit_lists_the_known_ones(tmp_path):
    (tmp_path / "box.msh").write_text("x")
    text = refused(tmp_path / "box.msh", unit="km")
    assert "unit is 'km'; allowed are m, cm, mm" in text
