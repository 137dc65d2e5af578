"""A model plays the scene that it was reduced from as `simulate` moves it, and refuses others."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo import runtime
from fenics_defo.errors import DefoError, SceneError, StepSizeError
from fenics_defo.scene import Recipe, Watcher, play, reduce_scene, simulate
from fenics_defo.scene import reducing as reducing_module
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
