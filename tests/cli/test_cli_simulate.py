"""``fenics-defo simulate``: its options, its output, its sentences, its exit status."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_files import SCENE, Box, strict_json

from fenics_defo.cli import defo
from fenics_defo.cli.simulate_options import checkpoint_cadence

Simulate = Callable[..., tuple[int, str, str]]


@pytest.fixture
def simulate(folder: Path, box: Box, capsys: pytest.CaptureFixture[str]) -> Simulate:
    """Write a scene, run the command in this process, return status, output and errors."""

    def run(*arguments: str, old: str = "", new: str = "") -> tuple[int, str, str]:
        (folder / "scene.toml").write_text(SCENE.format(mesh=box.path).replace(old, new, 1))
        status = defo.main(["simulate", "scene.toml", "--output", "out", *arguments])
        return status, *capsys.readouterr()

    return run


def table(path: str) -> Any:
    return np.genfromtxt(path, delimiter=",", names=True)


def test_a_beam_under_its_weight(simulate: Simulate, folder: Path) -> None:
    status, out, err = simulate()
    assert (status, err) == (0, "")
    for words in (
        "simulated: 0.1 s in 10 steps of 0.01 s, implicit-newmark",
        "dofs: 243, displacements of order 1, solver cholesky",
        "probe tip: at (",
        "written: summary.json, probes.csv, energy.csv, motion.pvd, checkpoint.npz in out",
    ):
        assert words in out
    record = strict_json((folder / "out" / "summary.json").read_text())
    assert (record["status"], record["steps"], record["dofs"]) == ("finished", 10, 243)
    probes, energy = table("out/probes.csv"), table("out/energy.csv")
    assert probes.dtype.names == ("time", "tip_x", "tip_y", "tip_z")
    assert len(probes) == len(energy) == 11
    # The tip falls freely before the waves from the wall are there.
    np.testing.assert_allclose(probes["tip_z"], -0.5 * 9.81 * probes["time"] ** 2, rtol=0.1)
    spent = energy["kinetic"] + energy["strain"] + energy["dissipated"]
    np.testing.assert_allclose(spent, energy["external"], atol=0.02 * energy["external"].max())
    assert (energy["dissipated"][1:] > 0.0).all()


def test_json_is_the_summary(simulate: Simulate, folder: Path) -> None:
    status, out, err = simulate("--json")
    assert (status, err) == (0, "")
    assert out.count("\n") == 1
    record, written = strict_json(out), strict_json((folder / "out" / "summary.json").read_text())
    assert {**record, "seconds": {}} == {**written, "seconds": {}}


def test_statics_have_a_row_a_load_step(simulate: Simulate) -> None:
    static = 'integrator = "static"\nstep = 0.25\nduration = 1'
    status, _, err = simulate(
        old='integrator = "implicit-newmark"\nstep = 0.01\nduration = 0.1', new=static
    )
    assert (status, err) == (0, "")
    probes, energy = table("out/probes.csv"), table("out/energy.csv")
    np.testing.assert_allclose(probes["time"], [0.0, 0.25, 0.5, 0.75, 1.0])
    steps = np.diff(probes["tip_z"])
    assert (steps < 0.0).all()
    np.testing.assert_allclose(steps, steps[0], rtol=0.1)  # it is not far from linear
    assert (energy["kinetic"] == 0.0).all()
    assert energy["external"][-1] == pytest.approx(energy["strain"][-1], rel=0.05)


def test_restart_goes_on_to_the_same_bits(simulate: Simulate, folder: Path) -> None:
    """The half of the run, made longer, is the whole one."""
    assert simulate()[0] == 0
    whole = [(folder / "out" / name).read_bytes() for name in ("probes.csv", "energy.csv")]
    assert simulate(old="duration = 0.1", new="duration = 0.05")[0] == 0
    half = (folder / "out" / "probes.csv").read_bytes()
    assert whole[0].startswith(half)
    assert half != whole[0]
    status, _, err = simulate("--restart")
    assert (status, err) == (0, "")
    assert [(folder / "out" / name).read_bytes() for name in ("probes.csv", "energy.csv")] == whole


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("stiffness", "stifness", ["[damping]", "'stifness'", 'mean "stiffness"']),
        ("box.msh", "bax.msh", ["bax.msh"]),
        ('"wall"', '"wal"', ["scene.toml", "[[fixed]]", "'wal'", "'wall'"]),
        ("[4, 0.3, 0.5]", "[5, 0.3, 0.5]", ["scene.toml", "tip", "5"]),
        ('kind = "gravity"', 'kind = "point"\nnode = 12\nvector = [1,0,0]', ["no node 12", "11"]),
        (
            'kind = "gravity"',
            'kind = "traction"\nregion = "tip"\nvector = [1, 0, 0]',
            ["scene.toml", "'tip'", "'wall'"],
        ),
        ("[[material]]\nlaw", "[require]\nrate = 5\nlaw", ["[require]", "'law'"]),
        ("implicit-newmark", "central-differences", ["scene.toml: [time]", "0.01"]),
    ],
)
def test_a_mistake_in_the_scene(simulate: Simulate, old: str, new: str, words: list[str]) -> None:
    status, out, err = simulate(old=old, new=new)
    assert (status, out) == (1, "")
    assert re.fullmatch(r"fenics-defo: [^\n]+\n", err)
    for word in words:
        assert word in err


def test_a_scene_without_material(simulate: Simulate) -> None:
    material = '[[material]]\nlaw = "st-venant-kirchhoff"\nyoung = 1e7\npoisson = 0.3\n'
    status, _, err = simulate(old=f"{material}density = 1000", new="")
    assert status == 1
    assert "[[material]]" in err
    assert "young, poisson and density" in err


def test_mistakes_in_the_command(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, words in (
        (["no.toml", "--output", "out"], "no.toml: cannot be read"),
        (["no.toml"], "--output"),
        (["no.toml", "--output", "out", "--restart", "--overwrite"], "--overwrite"),
        (["no.toml", "--output", "out", "--checkpoint-every", "soon"], "30s or 5min, got 'soon'"),
    ):
        assert defo.main(["simulate", *arguments]) == 1
        out, err = capsys.readouterr()
        assert out == ""
        assert words in err
        assert err.count("\n") == 1
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "cadence"),
    [
        ("100", (100, None)),
        ("30s", (None, 30.0)),
        ("1.5min", (None, 90.0)),
        ("2 h", (None, 7200.0)),
    ],
)
def test_cadences(text: str, cadence: tuple[Any, Any]) -> None:
    assert checkpoint_cadence(text) == cadence


@pytest.mark.parametrize("text", ["0", "-1", "1.5", "0s", "s", "nan", "5 weeks", ""])
def test_no_cadences(text: str) -> None:
    with pytest.raises(Exception, match="must be a number of steps"):
        checkpoint_cadence(text)


def test_an_unfinished_run_is_not_lost(simulate: Simulate, folder: Path) -> None:
    assert simulate()[0] == 0
    summary = folder / "out" / "summary.json"
    record = json.loads(summary.read_text())
    summary.write_text(json.dumps(record | {"status": "interrupted"}))
    status, out, err = simulate()
    assert (status, out) == (1, "")
    assert "--restart" in err
    assert simulate("--overwrite")[0] == 0
