"""A run fills its folder; stopped, failed or out of room, it leaves all in order and goes on."""

import errno
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from fenics_defo.errors import DefoError, DivergenceError, FileFormatError, SceneError
from fenics_defo.scene import Cadence, Watcher, load_checkpoint, running, simulate
from fenics_defo.scene.cadence import is_frame
from fenics_defo.scene.records import OutputTable, TimeTable
from tests.cli.cli_files import strict_json, write_box
from tests.unit.scene.swinging import Swinging

SCENE = """
[mesh]
file = "box.msh"
[[material]]
law = "neo-hookean"
young = 1e6
poisson = 0.3
density = 1000
[[fixed]]
region = "wall"
[time]
integrator = "implicit-newmark"
step = 0.1
duration = 2
[output]
every = 4
[[probe]]
name = "tip"
point = [4, 0, 0]
[[probe]]
name = "mid"
point = [2, 0, 0]
"""

Run = Callable[..., dict[str, Any]]


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_box(tmp_path / "box.msh")
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    monkeypatch.setattr(running, "build_simulation", Swinging)
    return path


@pytest.fixture
def run(scene: Path, tmp_path: Path) -> Run:
    def simulated(name: str = "out", **options: Any) -> dict[str, Any]:
        return simulate(scene, tmp_path / name, **options)

    return simulated


def stopping(after: int) -> Watcher:
    """One who stops the run after so many steps."""
    done: list[int] = []

    def stop() -> bool:
        done.append(1)
        return len(done) > after

    return Watcher(stop=stop)


def tables(folder: Path) -> tuple[bytes, bytes]:
    return (folder / "probes.csv").read_bytes(), (folder / "energy.csv").read_bytes()


def frames(folder: Path) -> list[float]:
    return list(pyvista.get_reader(folder / "motion.pvd").time_values)


def test_the_folder_holds_everything(run: Run, tmp_path: Path) -> None:
    record, out = run(), tmp_path / "out"
    assert json.loads((out / "summary.json").read_text()) == record
    assert (record["status"], record["steps"], record["newton_iterations"]) == ("finished", 20, 40)
    assert (record["energy_error"], record["energy_gain"]) == (0.25, 0.125)
    probes = np.genfromtxt(out / "probes.csv", delimiter=",", names=True)
    assert probes.dtype.names == ("time", "tip_x", "tip_y", "tip_z", "mid_x", "mid_y", "mid_z")
    np.testing.assert_allclose(probes["time"], 0.1 * np.arange(21), rtol=1e-12)
    assert record["probes"]["tip"]["displacement"][0] == probes["tip_x"][-1]
    largest = np.sqrt(sum(probes[f"mid_{c}"] ** 2 for c in "xyz")).max()
    assert record["probes"]["mid"]["largest"] == pytest.approx(largest)
    energy = np.genfromtxt(out / "energy.csv", delimiter=",", names=True)
    assert energy.dtype.names == ("time", "kinetic", "strain", "external", "dissipated")
    assert record["energies"]["kinetic"] == energy["kinetic"][-1]
    np.testing.assert_allclose(frames(out), [0.0, 0.4, 0.8, 1.2, 1.6, 2.0])
    assert sorted(path.name for path in out.iterdir()) == sorted([*record["files"], "motion"])


def test_the_series_holds_the_state(run: Run, tmp_path: Path) -> None:
    run()
    reader = pyvista.get_reader(tmp_path / "out" / "motion.pvd")
    reader.set_active_time_point(len(reader.time_values) - 1)
    (grid,) = reader.read()
    state = load_checkpoint(tmp_path / "out" / "checkpoint.npz").state
    np.testing.assert_array_equal(grid.point_data["displacement"], state.displacement)
    np.testing.assert_array_equal(grid.point_data["velocity"], state.velocity)


@pytest.mark.parametrize("stop", [0, 1, 7, 8, 19])
def test_an_interrupted_run_goes_on_to_the_same_bits(run: Run, tmp_path: Path, stop: int) -> None:
    run("whole")
    first = run("parts", watcher=stopping(stop))
    assert (first["status"], first["steps"]) == ("interrupted", stop)
    second = run("parts", restart=True)
    assert (second["status"], second["steps_now"]) == ("finished", 20 - stop)
    assert tables(tmp_path / "parts") == tables(tmp_path / "whole")
    assert frames(tmp_path / "parts") == frames(tmp_path / "whole")
    whole = json.loads((tmp_path / "whole" / "summary.json").read_text())
    for key in ("probes", "energies", "newton_iterations", "frames"):
        assert second[key] == whole[key]


class Killed(BaseException):
    pass


def test_a_killed_run_goes_on_from_its_checkpoint(run: Run, tmp_path: Path) -> None:
    """Rows and frames after the checkpoint are written anew."""
    run("whole")

    def kill(done: int, _total: int, _time: float) -> None:
        if done == 13:
            raise Killed

    with pytest.raises(Killed):
        run("killed", checkpoints=Cadence(steps=5), watcher=Watcher(moved=kill))
    out = tmp_path / "killed"
    assert json.loads((out / "summary.json").read_text())["status"] == "running"
    assert len((out / "probes.csv").read_text().splitlines()) == 1 + 14
    assert frames(out) == pytest.approx([0.0, 0.4, 0.8, 1.2])
    assert load_checkpoint(out / "checkpoint.npz").state.step == 10
    record = run("killed", restart=True)
    assert record["steps_now"] == 10
    assert tables(out) == tables(tmp_path / "whole")
    assert frames(out) == frames(tmp_path / "whole")


def test_a_finished_run_can_be_made_longer(run: Run, scene: Path, tmp_path: Path) -> None:
    scene.write_text(SCENE.replace("duration = 2", "duration = 1.2"))
    run("parts")
    scene.write_text(SCENE)
    assert run("parts", restart=True)["steps_now"] == 8
    run("whole")
    assert tables(tmp_path / "parts") == tables(tmp_path / "whole")
    assert run("parts", restart=True)["steps_now"] == 0
    assert tables(tmp_path / "parts") == tables(tmp_path / "whole")


def test_a_forgotten_restart_loses_nothing(run: Run, tmp_path: Path) -> None:
    run(watcher=stopping(3))
    before = tables(tmp_path / "out")
    with pytest.raises(DefoError, match=r"unfinished run.*0\.3 s.*--restart.*--overwrite"):
        run()
    assert tables(tmp_path / "out") == before
    assert run(overwrite=True)["status"] == "finished"
    assert run()["status"] == "finished"  # a finished one is replaced


def test_restart_needs_the_same_scene(run: Run, scene: Path, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"holds no checkpoint\.npz"):
        run(restart=True)
    run(watcher=stopping(3))
    before = tables(tmp_path / "out")
    text = SCENE.replace("young = 1e6", "young = 2e6").replace("step = 0.1", "step = 0.05")
    scene.write_text(text)
    with pytest.raises(FileFormatError, match="the tables material, time differ"):
        run(restart=True)
    assert tables(tmp_path / "out") == before
    scene.write_text(SCENE + '[solver]\nlinear = "pcg-amg"\n')
    assert run(restart=True)["status"] == "finished"


def test_restart_and_overwrite_exclude_each_other(run: Run) -> None:
    with pytest.raises(SceneError, match="exclude"):
        run(restart=True, overwrite=True)


@pytest.mark.parametrize("damage", ["cut", "other", "row"])
def test_a_damaged_folder_is_told(run: Run, tmp_path: Path, damage: str) -> None:
    run(watcher=stopping(5))
    out = tmp_path / "out"
    if damage == "cut":
        data = (out / "checkpoint.npz").read_bytes()
        (out / "checkpoint.npz").write_bytes(data[: len(data) // 2])
    elif damage == "other":
        (out / "checkpoint.npz").write_text("{}")
    else:
        (out / "probes.csv").write_text("time\n")
    with pytest.raises(FileFormatError, match=str(out)):
        run(restart=True)


def test_divergence_keeps_the_last_good_state(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Swinging, "fails_at", 8)
    with pytest.raises(DivergenceError):
        run()
    out = tmp_path / "out"
    record = json.loads((out / "summary.json").read_text())
    assert (record["status"], record["steps"]) == ("failed", 7)
    assert record["error"] == "the step failed"
    assert load_checkpoint(out / "checkpoint.npz").state.step == 7
    assert len((out / "probes.csv").read_text().splitlines()) == 1 + 8
    monkeypatch.undo()


def test_nan_reaches_no_file(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Swinging, "nan_at", 6)
    with pytest.raises(DefoError, match="NaN"):
        run()
    out = tmp_path / "out"
    for name in ("probes.csv", "energy.csv"):
        table = np.genfromtxt(out / name, delimiter=",", skip_header=1)
        assert np.isfinite(table).all()
        assert len(table) >= 6
    assert strict_json((out / "summary.json").read_text())["status"] == "failed"
    assert load_checkpoint(out / "checkpoint.npz").state.step < 6


@pytest.mark.parametrize("call", ["pwrite", "fsync"])
@pytest.mark.parametrize("after", [3, 12, 13])
def test_a_full_disk_loses_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, after: int
) -> None:
    """The disk is full at some write of the run; once there is room it goes on."""
    run("whole")
    real, calls = getattr(os, call), []

    def failing(*arguments: Any) -> Any:
        calls.append(1)
        if len(calls) > after:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(*arguments)

    monkeypatch.setattr(os, call, failing)
    with pytest.raises(DefoError, match=r"full/.*No space left"):
        run("full", checkpoints=Cadence(steps=2))
    monkeypatch.setattr(os, call, real)
    for name in ("probes.csv", "energy.csv"):
        text = (tmp_path / "full" / name).read_text()
        whole = (tmp_path / "whole" / name).read_text()
        assert whole.startswith(text)
        assert text.endswith("\n")
    if (tmp_path / "full" / "checkpoint.npz").exists():
        run("full", restart=True)
    else:
        run("full")
    assert tables(tmp_path / "full") == tables(tmp_path / "whole")
    assert frames(tmp_path / "full") == frames(tmp_path / "whole")


def test_less_output(run: Run, scene: Path, tmp_path: Path) -> None:
    run()  # whose frames go, for they are of another run
    scene.write_text(SCENE.replace("every = 4", "vtk = false\nrows = 6"))
    record, out = run(), tmp_path / "out"
    times = np.genfromtxt(out / "energy.csv", delimiter=",", names=True)["time"]
    np.testing.assert_allclose(times, [0.0, 0.6, 1.2, 1.8, 2.0])
    assert record["frames"] == 0
    assert sorted(path.name for path in out.iterdir()) == sorted(record["files"])


def test_frames_come_as_asked() -> None:
    def due(output: OutputTable, step: float, duration: float) -> list[int]:
        time = TimeTable(integrator="backward-euler", step=step, duration=duration)
        return [n for n in range(1, time.steps + 1) if is_frame(n, time, output)]

    assert due(OutputTable(every=3), 0.1, 1.0) == [3, 6, 9]
    assert due(OutputTable(interval=0.3), 0.1, 1.0) == [3, 6, 9]
    assert due(OutputTable(interval=0.25), 0.1, 1.0) == [3, 5, 8, 10]
    assert due(OutputTable(interval=0.01), 0.1, 0.5) == [1, 2, 3, 4, 5]
    assert due(OutputTable(), 0.1, 2.0) == list(range(1, 21))
    assert len(due(OutputTable(), 1e-3, 5.0)) == 100


def test_a_place_that_cannot_be_a_folder(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for place in ("file", "file/folder"):
        with pytest.raises(DefoError, match=f"{place}: cannot be made a folder"):
            simulate(scene, tmp_path / place)
