"""``fenics-defo reduce``, ``play`` and ``info`` of models: options, output, sentences, status."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cli_files import COMMANDS, SCENE, Box, finish, start, strict_json

from fenics_defo import runtime
from fenics_defo.cli import defo

Command = Callable[..., tuple[int, str, str]]

# The scene of the simulator's tests, with fewer files.
TEXT = SCENE + "[output]\nevery = 5\n"


@pytest.fixture
def command(folder: Path, box: Box, capsys: pytest.CaptureFixture[str]) -> Command:
    """Write the scene, run a command in this process, return status, output and errors."""

    def run(*arguments: str, old: str = "", new: str = "") -> tuple[int, str, str]:
        assert old in TEXT
        (folder / "scene.toml").write_text(TEXT.format(mesh=box.path).replace(old, new, 1))
        status = defo.main(list(arguments))
        return status, *capsys.readouterr()

    return run


REDUCE = ("reduce", "scene.toml", "--output", "model.npz")
PLAY = ("play", "model.npz", "scene.toml", "--output", "played")


def test_from_a_scene_to_a_model_to_a_folder(command: Command, folder: Path) -> None:
    status, out, err = command(*REDUCE, "--modes", "10", "--size", "30")
    assert (status, err) == (0, "")
    for words in (
        "file: model.npz, a reduced model of ",
        "model: r = 30 coordinates, cubic forces",
        "damping: 0 1/s of the mass, 0.001 s of the stiffness",
        "stored: 81 nodes, 32 cells",
        "probes: tip",
        "loads: gravity",
        "scene: scene.toml, mesh box.msh, 243 dofs, displacements of order 1",
    ):
        assert words in out
    told = out.partition("seconds:")[0]
    status, out, err = command("info", "model.npz")
    assert (status, out, err) == (0, told, "")
    status, out, err = command(*PLAY)
    assert (status, err) == (0, "")
    for words in (
        "played: 0.1 s in 10 steps of 0.01 s, implicit-newmark",
        "model: model.npz, r = 30, cubic forces",
        "times real time",
        "written: summary.json, probes.csv, energy.csv, motion.pvd in played",
    ):
        assert words in out
    status, out, err = command("info", "played")
    assert (status, err) == (0, "")
    assert out.startswith("played: ")
    assert command("simulate", "scene.toml", "--output", "full")[0] == 0
    full, played = (
        np.genfromtxt(folder / name / "probes.csv", delimiter=",", names=True)
        for name in ("full", "played")
    )
    np.testing.assert_allclose(
        played["tip_z"], full["tip_z"], rtol=0, atol=0.02 * np.abs(full["tip_z"]).max()
    )


def test_json(command: Command) -> None:
    status, out, err = command(*REDUCE, "--modes", "3", "--size", "4", "--json")
    assert (status, err) == (0, "")
    record = strict_json(out)
    assert (record["kind"], record["size"], record["force"]) == ("model", 4, "cubic")
    assert record["probes"] == {"tip": [4.0, 0.3, 0.5]}
    assert record["provenance"]["scene"]["file"] == "scene.toml"
    status, out, err = command("info", "model.npz", "--json")
    assert (status, err) == (0, "")
    told = strict_json(out)
    assert told == {key: value for key, value in record.items() if key != "seconds"}
    status, out, err = command(*PLAY, "--json")
    assert (status, err) == (0, "")
    assert strict_json(out)["model"] == "model.npz"


@pytest.mark.parametrize(
    ("law", "kind", "size"),
    [
        ("linear", "linear", 20),
        ("st-venant-kirchhoff", "cubic", 20),
        ("neo-hookean", "cubature", 20),
    ],
)
def test_the_law_settles_the_rest(command: Command, law: str, kind: str, size: int) -> None:
    assert command(*REDUCE, old="st-venant-kirchhoff", new=law)[0] == 0
    model = runtime.load("model.npz")
    assert (model.law.kind, model.size) == (kind, size)
    basis = model.provenance["basis"]
    assert basis["kind"] == ("linear" if law == "linear" else "modal-derivatives")


def test_a_share_in_place_of_a_size(command: Command) -> None:
    sizes = []
    for share in ("0.9", "0.999999"):
        assert command(*REDUCE, "--modes", "4", "--share", share)[0] == 0
        model = runtime.load("model.npz")
        assert model.provenance["basis"]["kept"] >= float(share)
        sizes.append(model.size)
    assert sizes[0] < sizes[1]


def test_snapshots_of_a_simulation(command: Command) -> None:
    assert command("simulate", "scene.toml", "--output", "full")[0] == 0
    status, _, err = command(*REDUCE, "--basis", "snapshots=full", "--size", "2")
    assert (status, err) == (0, "")
    assert runtime.load("model.npz").provenance["basis"]["kind"] == "snapshots"
    status, out, err = command(*REDUCE, "--basis", "snapshots=nothing")
    assert (status, out) == (1, "")
    assert "nothing" in err


@pytest.mark.parametrize(
    ("arguments", "old", "new", "words"),
    [
        (("--force", "cubic"), "st-venant-kirchhoff", "neo-hookean", "NeoHookean; choose --force"),
        (("--tolerance", "0"), "", "", "tolerance must lie between 0 and 1, got 0.0"),
        (("--tolerance", "nan"), "", "", "tolerance must lie between 0 and 1, got nan"),
        (("--basis", "linear", "--share", "0.9"), "", "", "not by a share"),
        (("--share", "0"), "", "", "share must be above 0 and at most 1, got 0.0"),
        (("--share", "nan"), "", "", "share must be above 0 and at most 1, got nan"),
        (("--basis", "snapshots=out", "--modes", "3"), "", "", "--modes"),
        (("--modes", "3", "--size", "99"), "", "", "size must be at most 9"),
        ((), "[4, 0.3, 0.5]", "[5, 0.3, 0.5]", "scene.toml: "),
        ((), 'kind = "gravity"', 'kind = "point"\nnode = 12\nvector = [1,0,0]', "no node 12"),
        ((), '"wall"', '"wall"\ncomponents = ["x"]', "3 rigid motions of the body"),
        ((), '"wall"', '"wall"\ndisplacement = [0, 0, 1]', "[[fixed]] 1: nodes that are moved"),
    ],
)
def test_a_mistake_in_a_reduction(
    command: Command, folder: Path, arguments: tuple[str, ...], old: str, new: str, words: str
) -> None:
    status, out, err = command(*REDUCE, *arguments, old=old, new=new)
    assert (status, out) == (1, "")
    assert re.fullmatch(r"fenics-defo: [^\n]+\n", err)
    assert words in err
    assert not (folder / "model.npz").exists()


def test_mistakes_in_the_commands(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, words in (
        (["reduce", "no.toml"], "--output"),
        (["reduce", "no.toml", "--output", "m.npz"], "no.toml: cannot be read"),
        ([*REDUCE, "--basis", "modal"], "modal-derivatives, linear, or snapshots=DIR"),
        ([*REDUCE, "--basis", "snapshots="], "snapshots=DIR"),
        ([*REDUCE, "--force", "quartic"], "quartic"),
        ([*REDUCE, "--modes", "0"], "whole number from 1"),
        (["play", "no.npz", "no.toml", "--output", "out"], "no.toml: cannot be read"),
        (["play", "no.npz"], "SCENE.toml"),
    ):
        assert defo.main(arguments) == 1
        out, err = capsys.readouterr()
        assert out == ""
        assert words in err
        assert err.count("\n") == 1
    assert list(folder.iterdir()) == []


def test_a_model_that_is_none(command: Command, folder: Path) -> None:
    (folder / "model.npz").write_text("no archive")
    status, out, err = command(*PLAY)
    assert (status, out) == (1, "")
    assert re.fullmatch(r"fenics-defo: model\.npz: [^\n]+\n", err)


def test_ctrl_c_ends_a_played_scene_in_order(command: Command, folder: Path) -> None:
    assert command(*REDUCE, "--modes", "3", "--size", "4")[0] == 0
    long = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(long.replace("duration = 0.1", "duration = 1e4"))
    process = start("fenics-defo", *PLAY, cwd=folder)
    rows = folder / "played" / "probes.csv"
    deadline = time.monotonic() + 60.0
    while not (rows.exists() and rows.read_bytes().count(b"\n") > 5):
        assert time.monotonic() < deadline
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    status, printed, err = finish(process)
    assert (status, printed) == (130, "")
    assert re.fullmatch(r"fenics-defo: interrupted at \S+ s of 10000 s; played holds [^\n]+\n", err)
    record = strict_json((folder / "played" / "summary.json").read_text())
    assert record["status"] == "interrupted"
    assert rows.read_bytes().count(b"\n") == record["steps"] + 2


@pytest.mark.mpi
def test_two_ranks_give_the_same_model(command: Command, folder: Path) -> None:
    load = 'kind = "traction"\nregion = "wall"\nvector = [1, 2, 3]\n[[load]]\nkind = "gravity"'
    arguments = (*REDUCE[:2], "--modes", "4", "--size", "8", "--output")
    assert command(*arguments, "one.npz", old='kind = "gravity"', new=load)[0] == 0
    mpiexec = Path(sys.executable).with_name("mpiexec")
    ranks = [str(mpiexec), "-n", "2", sys.executable, "-m", COMMANDS["fenics-defo"]]
    done = subprocess.run(
        [*ranks, *arguments, "two.npz"], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("model: r = 8") == 1
    one, two = runtime.load("one.npz"), runtime.load("two.npz")
    assert one.provenance["scene"] == two.provenance["scene"]
    assert list(one.loads) == list(two.loads)
    rng = np.random.default_rng(4)
    for q in 0.3 * rng.standard_normal((3, 8)):
        force = one.force(q)  # the modes, iterated on each number of ranks, tell the digits
        np.testing.assert_allclose(two.force(q), force, rtol=0, atol=1e-8 * np.abs(force).max())
    for name, load_row in one.loads.items():
        np.testing.assert_allclose(
            two.load(name), load_row, rtol=0, atol=1e-8 * np.abs(load_row).max()
        )
