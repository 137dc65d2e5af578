"""Simulations that are interrupted, killed, or run on two ranks."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista
from cli_files import COMMANDS, SCENE, Box, finish, start, strict_json

from fenics_defo.cli import defo

STEPS = 250  # of which the first are done when the run is stopped


@pytest.fixture(scope="module")
def work(box: Box, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene, and the results of a run that nothing disturbed in ``whole``."""
    folder = tmp_path_factory.mktemp("simulate")
    text = SCENE.format(mesh=box.path).replace("duration = 0.1", f"duration = {STEPS / 100}")
    (folder / "scene.toml").write_text(text + "[output]\nevery = 50\n")
    assert simulate(folder, "whole") == 0
    return folder


def simulate(folder: Path, name: str, *arguments: str) -> int:
    """In this process: DOLFINx need not load."""
    scene = str(folder / "scene.toml")
    return defo.main(["simulate", scene, "--output", str(folder / name), *arguments])


def wait_for_rows(path: Path, rows: int) -> None:
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        if path.exists() and path.read_bytes().count(b"\n") > rows:
            return
        time.sleep(0.005)
    pytest.fail(f"{path} has no {rows} rows")


def check_valid(folder: Path, *, whole: Path) -> None:
    """All that is there is a part of what the whole run wrote."""
    for name in ("probes.csv", "energy.csv"):
        part = (folder / name).read_bytes()
        assert part.endswith(b"\n")
        assert (whole / name).read_bytes().startswith(part)
    series = pyvista.get_reader(folder / "motion.pvd")
    times = series.time_values
    assert times == pyvista.get_reader(whole / "motion.pvd").time_values[: len(times)]
    series.set_active_time_point(len(times) - 1)
    assert series.read()[0].n_points > 0
    strict_json((folder / "summary.json").read_text())


def check_equal(folder: Path, *, whole: Path) -> None:
    for name in ("probes.csv", "energy.csv", "motion.pvd"):
        assert (folder / name).read_bytes() == (whole / name).read_bytes()


def test_ctrl_c_stops_after_a_step(work: Path) -> None:
    out = work / "interrupted"
    process = start("fenics-defo", "simulate", "scene.toml", "--output", "interrupted", cwd=work)
    wait_for_rows(out / "probes.csv", 5)
    process.send_signal(signal.SIGINT)
    status, printed, err = finish(process)
    assert (status, printed) == (130, "")
    said = re.fullmatch(
        r"fenics-defo: interrupted at (\S+) s of 2.5 s; [^\n]+--restart[^\n]+\n", err
    )
    assert said is not None, err
    record = strict_json((out / "summary.json").read_text())
    assert record["status"] == "interrupted"
    assert record["time"] == pytest.approx(float(said[1]))
    assert 5 <= record["steps"] < STEPS
    rows = (out / "probes.csv").read_bytes().count(b"\n") - 1
    assert rows == record["steps"] + 1
    check_valid(out, whole=work / "whole")
    assert simulate(work, "interrupted") == 1  # it is not lost by a forgotten --restart
    assert simulate(work, "interrupted", "--restart") == 0
    check_equal(out, whole=work / "whole")


def test_a_killed_run_goes_on(work: Path) -> None:
    out = work / "killed"
    arguments = ["simulate", "scene.toml", "--output", "killed", "--checkpoint-every", "20"]
    process = start("fenics-defo", *arguments, cwd=work)
    wait_for_rows(out / "probes.csv", 50)
    process.kill()
    finish(process)
    check_valid(out, whole=work / "whole")
    rows = (out / "probes.csv").read_bytes().count(b"\n") - 1
    assert rows >= 50
    assert strict_json((out / "summary.json").read_text())["status"] == "running"
    assert simulate(work, "killed", "--restart") == 0
    check_equal(out, whole=work / "whole")
    record = json.loads((out / "summary.json").read_text())
    assert rows - 22 <= STEPS - record["steps_now"] <= rows


@pytest.mark.mpi
def test_two_ranks_give_the_numbers_of_one(mpirun: Any, work: Path) -> None:
    text = (work / "scene.toml").read_text()
    (work / "short.toml").write_text(text.replace("duration = 2.5", "duration = 0.3"))
    module = COMMANDS["fenics-defo"]
    done = mpirun("-m", module, "simulate", "short.toml", "--output", "two", "--json", cwd=work)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("\n") == 1
    record = strict_json(done.stdout)
    assert (record["ranks"], record["steps"]) == (2, 30)
    check_close(work / "two", whole=work / "whole", rows=31)
    frame = "motion/frame_000000.vtu"
    one, two = (pyvista.read(work / name / frame) for name in ("whole", "two"))
    np.testing.assert_array_equal(one.points, two.points)
    np.testing.assert_array_equal(one.cells, two.cells)
    # One rank goes on with what two have begun.
    (work / "short.toml").write_text(text.replace("duration = 2.5", "duration = 0.5"))
    arguments = [str(work / "short.toml"), "--output", str(work / "two"), "--restart"]
    assert defo.main(["simulate", *arguments]) == 0
    check_close(work / "two", whole=work / "whole", rows=51)


def check_close(folder: Path, *, whole: Path, rows: int) -> None:
    """To solver tolerance: sums over ranks are rounded in another order."""
    for name in ("probes.csv", "energy.csv"):
        table, one = (
            np.loadtxt(place / name, delimiter=",", skiprows=1) for place in (folder, whole)
        )
        assert len(table) == rows
        np.testing.assert_allclose(table, one[:rows], rtol=0.0, atol=1e-9 * np.abs(one).max())


@pytest.mark.mpi
def test_two_ranks_fail_with_one_sentence(mpirun: Any, work: Path) -> None:
    text = (work / "scene.toml").read_text().replace("[4, 0.3, 0.5]", "[4, 0.3, 9]")
    (work / "wrong.toml").write_text(text)
    module = COMMANDS["fenics-defo"]
    done = mpirun("-m", module, "simulate", "wrong.toml", "--output", "wrong", cwd=work)
    assert (done.returncode, done.stdout) == (1, "")
    assert re.fullmatch(r"fenics-defo: wrong\.toml: [^\n]+'tip'[^\n]+\n", done.stderr)


@pytest.mark.mpi
def test_ctrl_c_on_two_ranks(work: Path) -> None:
    """The launcher passes it on to both, which stop after the same step."""
    mpiexec = Path(sys.executable).with_name("mpiexec")
    module, out = COMMANDS["fenics-defo"], work / "both"
    command = [str(mpiexec), "-n", "2", sys.executable, "-m", module]
    process = subprocess.Popen(
        [*command, "simulate", "scene.toml", "--output", "both"],
        cwd=work,
        env=os.environ,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_for_rows(out / "probes.csv", 5)
    process.send_signal(signal.SIGINT)
    _, printed, err = finish(process)
    assert "simulated" not in printed
    assert err.count("fenics-defo: interrupted at") == 1
    record = strict_json((out / "summary.json").read_text())
    assert record["status"] == "interrupted"
    rows = (out / "probes.csv").read_bytes().count(b"\n") - 1
    assert rows == record["steps"] + 1
