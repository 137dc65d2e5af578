"""A model plays the scene that it was reduced from as `simulate` moves it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from fenics_defo import runtime
from fenics_defo.scene import Recipe, play, read_scene, reduce_scene, simulate
from fenics_defo.scene.records import OutputTable
from tests.unit.scene.two_cells import IMPULSES, INITIAL, MOTIONS, SCENE, write_scene

ROOT = Path(__file__).resolve().parents[3]
NO_FRAMES = OutputTable(vtk=False)
# All motions of the body: what is left is round-off, amplified by the motion.
ALL = Recipe(basis="linear", modes=MOTIONS)
NEWMARK = 'integrator = "implicit-newmark"\nstep = 1e-3\nduration = 0.04'


def read(folder: Path, name: str) -> Any:
    return np.genfromtxt(folder / name, delimiter=",", names=True)


def compare(folder: Path, *, probes: float, energies: float) -> None:
    """Compare the tables of ``full`` and ``played``, relative to their largest numbers."""
    for name, allowed in (("probes.csv", probes), ("energy.csv", energies)):
        full, played = read(folder / "full", name), read(folder / "played", name)
        assert played.dtype.names == full.dtype.names
        np.testing.assert_allclose(played["time"], full["time"], rtol=1e-12)
        columns = [column for column in full.dtype.names if column != "time"]
        scale = max(np.abs(full[column]).max() for column in columns)
        assert scale > 0.0
        for column in columns:
            np.testing.assert_allclose(
                played[column], full[column], rtol=0.0, atol=allowed * scale, err_msg=column
            )


def run_both(folder: Path, text: str, recipe: Recipe = ALL) -> dict[str, Any]:
    """Simulate a scene, reduce it and play it; returns the summary of what was played."""
    scene = write_scene(folder, text)
    simulate(scene, folder / "full")
    reduce_scene(scene, folder / "model.npz", recipe=recipe)
    return play(folder / "model.npz", scene, folder / "played")


@pytest.mark.parametrize(
    "time",
    [
        pytest.param(NEWMARK, id="newmark"),
        pytest.param(NEWMARK + "\nbeta = 0.3025\ngamma = 0.6", id="damped newmark"),
        pytest.param(NEWMARK + "\ntolerance = 1e-11", id="converged newmark"),
        pytest.param(NEWMARK.replace("implicit-newmark", "backward-euler"), id="backward euler"),
        pytest.param(
            NEWMARK.replace("implicit-newmark", "central-differences"), id="central differences"
        ),
        pytest.param(
            NEWMARK.replace("implicit-newmark", "symplectic-euler"), id="symplectic euler"
        ),
    ],
)
def test_a_model_of_all_motions_is_the_simulation(tmp_path: Path, time: str) -> None:
    text = SCENE.replace(NEWMARK, time) + INITIAL + IMPULSES
    record = run_both(tmp_path, text)
    assert (record["status"], record["steps"], record["dofs"]) == ("finished", 40, MOTIONS)
    # The scene is violent enough for the comparison to mean something.
    assert read(tmp_path / "full", "probes.csv")["tip_x"].max() > 0.01
    explicit = "central" in time or "symplectic" in time
    assert explicit == (record["newton_iterations"] == 0)
    assert record["energy_gain"] < 0.05
    compare(tmp_path, probes=1e-9, energies=1e-6 if explicit else 1e-9)


STATIC = 'integrator = "static"\nstep = 0.2\nduration = 1\ntolerance = 1e-11'


def test_equilibria_of_a_model_of_all_motions(tmp_path: Path) -> None:
    text = SCENE.replace(NEWMARK, STATIC).replace(
        'kind = "sine", frequency = 4', 'kind = "ramp", duration = 1'
    )
    record = run_both(tmp_path, text)
    assert (record["status"], record["integrator"]) == ("finished", "static")
    assert record["newton_iterations"] >= 10
    assert read(tmp_path / "full", "probes.csv")["tip_x"].max() > 0.05
    compare(tmp_path, probes=1e-9, energies=1e-9)


def test_some_nodes_are_enough(tmp_path: Path) -> None:
    """Only what a scene requires is stored: probes and tables need no nodes, frames all."""
    text = SCENE + '[require]\noutputs = "z>0.9"\n'
    record = run_both(tmp_path, text)
    assert runtime.load(tmp_path / "model.npz").nodes.tolist() == [8, 9, 10, 11]
    assert "motion.pvd" not in record["files"]
    assert not (tmp_path / "played" / "motion.pvd").exists()
    compare(tmp_path, probes=1e-9, energies=1e-9)


def test_linear_forces_of_a_linear_body(tmp_path: Path) -> None:
    text = SCENE.replace('law = "st-venant-kirchhoff"', 'law = "linear"')
    record = run_both(tmp_path, text, Recipe(modes=MOTIONS))
    assert record["force"] == "linear"
    compare(tmp_path, probes=1e-9, energies=1e-9)


def test_bending_needs_more_than_modes(tmp_path: Path) -> None:
    """A strip bent into a hook: modes alone cannot shorten it, their derivatives can."""
    scene = read_scene(ROOT / "scenes" / "bent_cantilever.toml")
    simulate(scene, tmp_path / "full")
    full = np.array(read(tmp_path / "full", "probes.csv").tolist())[:, 1:]
    errors = {}
    for name, recipe in (
        ("linear", Recipe(basis="linear", modes=20)),
        ("derivatives", Recipe(modes=6, size=12)),
        ("snapshots", Recipe(basis="snapshots", snapshots=str(tmp_path / "full"), size=8)),
    ):
        reduce_scene(scene, tmp_path / "model.npz", recipe=recipe)
        play(tmp_path / "model.npz", replace(scene, output=NO_FRAMES), tmp_path / name)
        played = np.array(read(tmp_path / name, "probes.csv").tolist())[:, 1:]
        errors[name] = np.abs(played - full).max() / np.abs(full).max()
    assert errors["linear"] > 0.5
    assert errors["derivatives"] < 0.03
    assert errors["snapshots"] < 1e-4


SLAB = """
[mesh]
file = "two.msh"
[[material]]
law = "st-venant-kirchhoff"
young = 2e5
poisson = 0.3
density = 1000
[initial]
velocity = [0, 0.5, 1]
spin = [0, 6, 1]
displacement = [0, 0, 1]
[[load]]
kind = "gravity"
[time]
integrator = "implicit-newmark"
step = 2e-3
duration = 0.2
tolerance = 1e-10
[[probe]]
name = "corner"
point = [0.4, 0.3, 1]
[output]
every = 50
"""


def test_a_model_in_flight(tmp_path: Path) -> None:
    """Rigid motion and all 30 deformations: what differs are two rules of second order."""
    recipe, errors = Recipe(basis="linear", modes=36 - 6, force="cubic"), []
    for step in ("4e-3", "2e-3"):
        record = run_both(tmp_path, SLAB.replace("2e-3", step), recipe)
        full, played = (read(tmp_path / name, "probes.csv") for name in ("full", "played"))
        columns = [name for name in full.dtype.names if name != "time"]
        errors.append(max(np.abs(played[c] - full[c]).max() for c in columns))
    assert record["dofs"] == 30
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    compare(tmp_path, probes=2e-4, energies=5e-3)
    full, played = (read_last_frame(tmp_path / name) for name in ("full", "played"))
    for name, allowed in (("displacement", 2e-4), ("velocity", 2e-3)):
        scale = np.abs(full[name]).max()
        np.testing.assert_allclose(played[name], full[name], rtol=0, atol=allowed * scale)


def read_last_frame(folder: Path) -> Any:
    reader = pyvista.get_reader(folder / "motion.pvd")
    reader.set_active_time_point(len(reader.time_values) - 1)
    (grid,) = reader.read()
    return grid.point_data


def test_frames_are_those_of_the_simulation(tmp_path: Path) -> None:
    run_both(tmp_path, SCENE.replace(NEWMARK, NEWMARK.replace("0.04", "0.01")))
    full, played = (read_last_frame(tmp_path / name) for name in ("full", "played"))
    for name in ("displacement", "velocity"):
        scale = np.abs(full[name]).max()
        np.testing.assert_allclose(played[name], full[name], rtol=0, atol=1e-9 * scale)
    meshes = [pyvista.get_reader(tmp_path / n / "motion.pvd").read()[0] for n in ("full", "played")]
    np.testing.assert_array_equal(meshes[0].points, meshes[1].points)
    np.testing.assert_array_equal(meshes[0].cells, meshes[1].cells)
