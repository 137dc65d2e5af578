"""A model plays the scene that it was reduced from as `simulate` moves it, and refuses others."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo import runtime
from fenics_defo.errors import (
    DefoError,
    DivergenceError,
    FileFormatError,
    SceneError,
    StepSizeError,
)
from fenics_defo.scene import Recipe, Watcher, play, reduce_scene, simulate
from tests.unit.scene.two_cells import IMPULSES, INITIAL, MOTIONS, SCENE, write_scene

# All motions of the body: what is left is round-off, amplified by the motion.
ALL = Recipe(basis="linear", modes=MOTIONS)
NEWMARK = 'integrator = "implicit-newmark"\nstep = 1e-3\nduration = 0.04'

Text = Callable[..., Path]


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


def test_linear_forces_of_a_linear_body(tmp_path: Path) -> None:
    text = SCENE.replace('law = "st-venant-kirchhoff"', 'law = "linear"')
    record = run_both(tmp_path, text, Recipe(modes=MOTIONS))
    assert record["force"] == "linear"
    compare(tmp_path, probes=1e-9, energies=1e-9)


def test_few_coordinates_come_near(tmp_path: Path) -> None:
    """Gravity and a push along x bend the body about one axis: a few modes tell most of it."""
    text = SCENE + IMPULSES
    scene = write_scene(tmp_path, text)
    simulate(scene, tmp_path / "full")
    errors = {}
    for recipe in (Recipe(modes=4, size=4), Recipe(modes=4, size=12)):
        reduce_scene(scene, tmp_path / "model.npz", recipe=recipe)
        play(tmp_path / "model.npz", scene, tmp_path / "played")
        full, played = (read(tmp_path / name, "probes.csv") for name in ("full", "played"))
        columns = [name for name in full.dtype.names if name != "time"]
        scale = max(np.abs(full[column]).max() for column in columns)
        errors[recipe.size] = max(np.abs(played[c] - full[c]).max() for c in columns) / scale
    assert errors[12] < 0.5 * errors[4]
    assert errors[12] < 0.05
