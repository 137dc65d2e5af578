"""``mesh-to-modes`` from a mesh file to numbers, files and words."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_files import HEIGHT, LENGTH, STEEL, WIDTH, Box

from fenics_defo.beams import RectangularSection, cantilever_frequencies
from fenics_defo.cli import mesh_to_modes

Compute = Callable[..., dict[str, Any]]
Captured = pytest.CaptureFixture[str]

PROMISED = {
    "frequencies_hz",
    "residuals",
    "rigid_modes",
    "complete",
    "effective_mass",
    "dofs",
    "cells",
    "seconds",
}


def test_frequencies_of_a_steel_cantilever(modes_json: Compute) -> None:
    found = modes_json("--fixed", "wall", "--count", "2", "--order", "2")
    expected = cantilever_frequencies(
        length=LENGTH, section=RectangularSection(width=WIDTH, height=HEIGHT), count=2, **STEEL
    )
    np.testing.assert_allclose(found["frequencies_hz"], expected, rtol=0.02)
    assert found["materials"] == [
        {"region": None, "law": "st-venant-kirchhoff", **STEEL, "source": "steel (default)"}
    ]


def test_json_holds_what_is_promised(modes_json: Compute, box: Box) -> None:
    found = modes_json("--count", "9")
    assert found.keys() >= PROMISED
    assert found["rigid_modes"] == 6
    assert found["complete"] is True
    assert found["cells"] == len(box.cells)
    assert found["dofs"] == 3 * len(box.points)
    assert list(found["effective_mass"]) == ["x", "y", "z", "rx", "ry", "rz"]
    for column in found["effective_mass"].values():  # of a free body: all in the rigid modes
        np.testing.assert_allclose([sum(column[:6]), *column[6:]], [1, 0, 0, 0], atol=1e-9)
    assert len(found["residuals"]) == len(found["frequencies_hz"]) == 9
    assert max(found["residuals"]) < 1e-6
    assert {"read", "assemble", "factorise", "solve", "count"} <= found["seconds"].keys()
    assert min(found["seconds"].values()) >= 0.0


def test_every_kind_of_selection_means_the_same_wall(
    modes_json: Compute, folder: Path, box: Box
) -> None:
    at_wall = box.numbers[box.points[:, 0] == 0.0]
    (folder / "wall.bou").write_text(",".join(map(str, at_wall)))
    selections = ["wall", "5", "x<1e-6", "x==0", "nodes:wall.bou"]
    runs = [modes_json("--fixed", s, "--count", "3", "--no-count") for s in selections]
    for run in runs:
        assert run["fixed_nodes"] == len(at_wall)
        np.testing.assert_allclose(
            run["frequencies_hz"], runs[0]["frequencies_hz"], rtol=1e-8, err_msg=str(run["fixed"])
        )


def test_components_hold_a_body_bit_by_bit(modes_json: Compute) -> None:
    rigid = [
        modes_json("--no-count", "--count", "6", *options)["rigid_modes"]
        for options in (
            ["--free"],
            ["--fixed-in", "x", "x==0"],  # what is left: y, z and the turn about x
            ["--fixed-in", "x", "x==0", "--fixed-in", "y", "y==0"],
            ["--fixed-in", "xyz", "x==0"],
        )
    ]
    assert rigid == [6, 3, 1, 0]


def test_dropping_the_rigid_modes(modes_json: Compute) -> None:
    kept = modes_json("--count", "8")
    dropped = modes_json("--count", "2", "--drop-rigid")
    assert dropped["rigid_modes"] == 0
    np.testing.assert_allclose(dropped["frequencies_hz"], kept["frequencies_hz"][6:], rtol=1e-8)


@pytest.mark.parametrize("solver", ["krylov-schur", "iterative"])
def test_solvers_agree(modes_json: Compute, solver: str) -> None:
    ours = modes_json("--fixed", "wall", "--count", "3")
    other = modes_json("--fixed", "wall", "--count", "3", "--solver", solver)
    np.testing.assert_allclose(other["frequencies_hz"], ours["frequencies_hz"], rtol=1e-6)
    assert other["complete"] is (solver == "krylov-schur")


def test_stiffness_and_density_scale_the_frequencies(modes_json: Compute) -> None:
    steel = modes_json("--fixed", "wall", "--count", "3")
    softer = modes_json(
        *("--fixed", "wall", "--count", "3"),
        *("--young", str(STEEL["young"] / 4.0), "--density", str(9.0 * STEEL["density"])),
    )
    np.testing.assert_allclose(
        softer["frequencies_hz"], np.array(steel["frequencies_hz"]) / 6.0, rtol=1e-8
    )
    assert softer["materials"][0]["source"] == "from --young, --density"


def test_materials_by_region(modes_json: Compute, folder: Path) -> None:
    (folder / "two.toml").write_text(
        "[[material]]\nyoung = 2.1e11\npoisson = 0.3\ndensity = 7850\n"
        '[[material]]\nregion = "far"\nyoung = 2.1e11\npoisson = 0.3\ndensity = 15700\n'
    )
    found = modes_json("--fixed", "wall", "--count", "1", "--materials", "two.toml")
    assert found["total_mass"] == pytest.approx(1.5 * 7850 * LENGTH * WIDTH * HEIGHT)
    assert [m["region"] for m in found["materials"]] == [None, "far"]


def test_the_mesh_files_material_and_what_replaces_it(folder: Path, capsys: Captured) -> None:
    Path("body.veg").write_text(
        "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n"
        "*MATERIAL soft\nENU, 1000, 1e6, 0.4\n*REGION\nallElements, soft\n"
    )
    assert mesh_to_modes.main(["body.veg", "--count", "7"]) == 0
    out, _ = capsys.readouterr()
    assert "young 1e6 Pa, poisson 0.4, density 1000 kg/m3" in out
    assert "mesh file" in out
    assert mesh_to_modes.main(["body.veg", "--count", "7", "--young", "5e6"]) == 0
    out, err = capsys.readouterr()
    assert "young 5e6 Pa, poisson 0.3 (default), density 7850 kg/m3 (default)" in out
    assert re.search("note: .*mesh file is replaced .*--young.* poisson 0.3, density 7850", err)


def test_the_file_of_modes(modes_json: Compute, box: Box, folder: Path) -> None:
    found = modes_json("--fixed", "wall", "--count", "4", "--output", "out.npz")
    with np.load(folder / "out.npz") as arrays:
        assert arrays["frequencies"].tolist() == found["frequencies_hz"]
        np.testing.assert_allclose(arrays["points"], box.points, atol=1e-15)
        assert sorted(map(sorted, arrays["cells"])) == sorted(map(sorted, box.cells))
        np.testing.assert_array_equal(
            np.sort(arrays["cells"], axis=1), np.sort(box.cells, axis=1)
        )  # cell by cell in the file's order
        held = box.points[:, 0] == 0.0
        assert arrays["shapes"].shape == (4, len(box.points), 3)
        assert np.abs(arrays["shapes"][:, held]).max() == 0.0
        assert np.abs(arrays["shapes"][:, ~held]).max() > 0.0
    assert found["files"] == ["out.npz"]
    assert sorted(path.name for path in folder.iterdir()) == ["out.npz"]


def test_second_order_appends_its_nodes(modes_json: Compute, box: Box, folder: Path) -> None:
    found = modes_json("--fixed", "wall", "--count", "1", "--order", "2")
    with np.load(folder / "modes.npz") as arrays:
        assert 3 * len(arrays["points"]) == found["dofs"] > 3 * len(box.points)
        np.testing.assert_allclose(arrays["points"][: len(box.points)], box.points, atol=1e-15)


def test_table_and_summary(folder: Path, box: Box, capsys: Captured) -> None:
    arguments = [str(box.path), "--fixed", "wall", "--count", "5", "--vtk", "modes.vtu"]
    assert mesh_to_modes.main(arguments) == 0
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err
    assert "…" not in out
    assert max(map(len, out.splitlines())) < 80
    rows = re.findall(r"^ +(\d+) +([\d.]+) +[\d.]+ m?s  (.{10})", out, flags=re.MULTILINE)
    assert [int(number) for number, _, _ in rows] == [1, 2, 3, 4, 5]
    assert [motion.strip() for _, _, motion in rows[:2]] == ["bending z", "bending y"]
    with np.load(folder / "modes.npz") as arrays:
        np.testing.assert_allclose([float(f) for _, f, _ in rows], arrays["frequencies"], rtol=5e-6)
    for words in (
        "material: steel (default), young 2.1e11 Pa, poisson 0.3, density 7850 kg/m3",
        "fixed: 9 of 81 nodes (wall)",
        "modes: 5, none of them rigid",
        "complete: proved by an inertia count",
        "largest residual:",
        "written: modes.npz, modes.vtu",
    ):
        assert words in out
    assert (folder / "modes.vtu").read_bytes().startswith(b"<?xml")


def test_what_was_not_asked_for_is_said(folder: Path, box: Box, capsys: Captured) -> None:
    assert mesh_to_modes.main([str(box.path), "--count", "7", "--no-count"]) == 0
    out, err = capsys.readouterr()
    assert "complete: not checked (--no-count)" in out
    assert "fixed: nothing, the body is free" in out
    assert "modes: 7, 6 of them rigid" in out
    assert err == "note: no --fixed: the body is free to move as a whole\n"
    assert mesh_to_modes.main([str(box.path), "--count", "7", "--free"]) == 0
    assert capsys.readouterr().err == ""


def test_a_picture(folder: Path, box: Box, capsys: Captured) -> None:
    arguments = [str(box.path), "--fixed", "wall", "--count", "1", "--picture", "modes.png"]
    assert mesh_to_modes.main(arguments) == 0, capsys.readouterr().err
    assert (folder / "modes.png").read_bytes().startswith(b"\x89PNG")
