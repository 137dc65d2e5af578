"""``fenics-defo info`` of meshes and of modes."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_files import HEIGHT, LENGTH, SCENE, WIDTH, Box, strict_json

from fenics_defo.cli import defo
from fenics_defo.cli.mesh_figures import count_pieces, scaled_jacobians, volume
from fenics_defo.fem.sources import SourceMesh, source_from_arrays

Captured = pytest.CaptureFixture[str]


def test_what_a_mesh_holds(box: Box, capsys: Captured) -> None:
    assert defo.main(["info", str(box.path), "--json"]) == 0
    found = strict_json(capsys.readouterr().out)
    assert (found["kind"], found["cell_type"], found["order"]) == ("mesh", "hexahedron", 1)
    assert (found["nodes"], found["cells"]) == (len(box.points), len(box.cells))
    assert found["bounding_box"] == [[0.0, 0.0, 0.0], [LENGTH, WIDTH, HEIGHT]]
    assert found["volume"] == pytest.approx(LENGTH * WIDTH * HEIGHT)
    assert found["pieces"] == 1
    assert found["quality"]["min"] == pytest.approx(1.0)
    assert found["groups"] == [
        {"name": "wall", "number": 5, "dimension": 2, "size": 4},
        {"name": "near", "number": 7, "dimension": 3, "size": 16},
        {"name": "far", "number": 8, "dimension": 3, "size": 16},
    ]


def test_a_mesh_in_words(box: Box, capsys: Captured) -> None:
    assert defo.main(["info", str(box.path)]) == 0
    out = capsys.readouterr().out
    for words in (
        "cells: 32 hexahedra of 8 nodes (order 1)",
        "box: 0 <= x <= 4, 0 <= y <= 1, 0 <= z <= 0.5 (m)",
        "volume: 2 m3",
        "  5   4 facets  wall",
        "  7  16 cells   near",
        "materials: none in the file",
    ):
        assert words in out


def test_modes_need_numpy_only(
    modes_json: Callable[..., dict[str, Any]], folder: Path, capsys: Captured
) -> None:
    computed = modes_json("--fixed", "wall", "--count", "3")
    code = (
        "import sys\n"
        "class NumpyAlone:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        top = name.partition('.')[0]\n"
        "        if top not in {'numpy', 'fenics_defo', *sys.stdlib_module_names}:\n"
        "            raise ModuleNotFoundError(name, name=name)\n"
        "sys.meta_path.insert(0, NumpyAlone())\n"
        "from fenics_defo.cli.defo import main\n"
        "sys.exit(main(['info', 'modes.npz', *sys.argv[1:]]))\n"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", code, *options], capture_output=True, text=True, check=False
        )
        for options in ([], ["--json"])
    ]
    assert [(run.returncode, run.stderr) for run in runs] == [(0, "")] * 2
    found = strict_json(runs[1].stdout)
    assert found["kind"] == "modes"
    for key in ("frequencies_hz", "effective_mass", "complete", "rigid_modes", "motion"):
        assert found[key] == computed[key]
    assert "modes: 3, none of them rigid" in runs[0].stdout
    assert "bending z" in runs[0].stdout


def test_modes_are_known_by_their_content(
    modes_json: Callable[..., dict[str, Any]], folder: Path, capsys: Captured
) -> None:
    modes_json("--fixed", "wall", "--count", "1", "--output", "result")
    assert defo.main(["info", "result", "--json"]) == 0
    assert strict_json(capsys.readouterr().out)["kind"] == "modes"


def test_an_archive_that_is_not_ours(folder: Path, capsys: Captured) -> None:
    np.savez("other.npz", a=np.ones(3))
    assert defo.main(["info", "other.npz"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fenics-defo: other.npz: ")


REGULAR = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)


def tetrahedron(points: np.ndarray) -> SourceMesh:
    return source_from_arrays(points, np.array([[0, 1, 2, 3]]))


def test_quality_is_one_for_regular_cells_and_vanishes_for_flat_ones() -> None:
    assert scaled_jacobians(tetrahedron(REGULAR))[0] == pytest.approx(1.0)
    flattened = [
        scaled_jacobians(tetrahedron(REGULAR * [1.0, 1.0, h]))[0] for h in (1.0, 0.1, 1e-3)
    ]
    assert flattened[0] > flattened[1] > flattened[2] > 0.0
    assert flattened[2] < 0.01


def test_quality_does_not_depend_on_the_corner_the_place_or_the_size() -> None:
    rng = np.random.default_rng(3)
    points = REGULAR + 0.3 * rng.normal(size=(4, 3))
    reference = scaled_jacobians(tetrahedron(points))[0]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    for order in ([1, 2, 3, 0], [3, 0, 2, 1], [2, 3, 0, 1]):
        moved = 1e-3 * points[order] @ turn + [5.0, 6.0, 7.0]
        assert scaled_jacobians(tetrahedron(moved))[0] == pytest.approx(reference, rel=1e-6)


def test_quality_of_sheared_hexahedra_is_the_sine() -> None:
    angle = 0.4
    cube = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    cube[:, 0] += np.tan(angle) * cube[:, 1]
    mesh = source_from_arrays(cube, np.arange(8)[None], kind="hexahedron")
    assert scaled_jacobians(mesh)[0] == pytest.approx(np.cos(angle))
    assert volume(mesh) == pytest.approx(1.0)  # a shear keeps it


def test_volume_of_a_curved_tetrahedron() -> None:
    """A quadratic map of the unit tetrahedron whose determinant 1 + a (2x + y) is integrable."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    nodes = np.vstack([corners, [corners[list(e)].mean(axis=0) for e in edges]])
    a = 0.3
    curved = nodes.copy()
    curved[:, 0] += a * (nodes[:, 0] ** 2 + nodes[:, 0] * nodes[:, 1])
    mesh = source_from_arrays(curved, np.arange(10)[None])
    assert volume(mesh) == pytest.approx(1 / 6 + a * 3 / 24)  # mean of x and of y: 1/24


def test_pieces_share_no_node() -> None:
    points = np.vstack([REGULAR, REGULAR + 10.0])
    assert count_pieces(source_from_arrays(points, np.array([[0, 1, 2, 3], [4, 5, 6, 7]]))) == 2


def test_a_scene_and_its_results(box: Box, folder: Path, capsys: Captured) -> None:
    (folder / "scene.toml").write_text(SCENE.format(mesh=box.path))
    assert defo.main(["info", "scene.toml"]) == 0
    out = capsys.readouterr().out
    for words in (
        "material: young 1e7 Pa, poisson 0.3, density 1000 kg/m3 (st-venant-kirchhoff)",
        "fixed: wall along xyz",
        "load: gravity (0, 0, -9.81)",
        "time: 0.1 s in 10 steps of 0.01 s, implicit-newmark",
        "probe: tip at (4, 0.3, 0.5) m",
    ):
        assert words in out
    assert defo.main(["info", "scene.toml", "--json"]) == 0
    scene = strict_json(capsys.readouterr().out)
    assert (scene["kind"], scene["steps"], scene["damping"]["stiffness"]) == ("scene", 10, 1e-3)
    assert defo.main(["simulate", "scene.toml", "--output", "out"]) == 0
    told = capsys.readouterr().out
    assert defo.main(["info", "out"]) == 0
    assert capsys.readouterr().out == told
    assert defo.main(["info", "out", "--json"]) == 0
    results = strict_json(capsys.readouterr().out)
    assert (results["kind"], results["status"]) == ("results", "finished")


@pytest.mark.parametrize("text", [None, "", "[]", '{"status": "finished"}', "\0"])
def test_folders_that_hold_no_results(text: str | None, folder: Path, capsys: Captured) -> None:
    (folder / "out").mkdir()
    if text is not None:
        (folder / "out" / "summary.json").write_text(text)
    assert defo.main(["info", "out"]) == 1
    err = capsys.readouterr().err
    assert err.startswith("fenics-defo: out")
    assert err.count("\n") == 1
