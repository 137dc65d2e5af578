"""The commands as processes: what they load, pipes, Ctrl-C, several ranks."""

import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from cli_files import COMMANDS, Box, finish, start, strict_json

from fenics_defo.cli import progress

LIGHT = """
import sys
from {module} import main
status = main({arguments!r})
heavy = {{"numpy", "scipy", "dolfinx", "mpi4py", "ufl", "rich", "pyvista", "gmsh", "meshio"}}
print("loaded:", *sorted(heavy & set(sys.modules)))
sys.exit(status)
"""


@pytest.mark.parametrize(
    ("command", "arguments", "status"),
    [
        ("mesh-to-modes", ["--help"], 0),
        ("mesh-to-modes", ["--version"], 0),
        ("mesh-to-modes", ["m.msh", "--count", "0"], 1),
        ("fenics-defo", ["--help"], 0),
        ("fenics-defo", ["info", "--help"], 0),
    ],
)
def test_answers_without_loading_anything(command: str, arguments: list[str], status: int) -> None:
    code = LIGHT.format(module=COMMANDS[command], arguments=arguments)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == status, done.stderr
    assert done.stdout.splitlines()[-1] == "loaded:"
    assert len(done.stdout + done.stderr) > 20


def test_help_names_everything_and_fits(capsys: pytest.CaptureFixture[str]) -> None:
    from fenics_defo.cli.mesh_to_modes import build_parser

    build_parser().print_help()
    text = capsys.readouterr().out
    for word in ("SELECTION is one of", "nodes:FILE", "Examples", "mpiexec", "[Pa]", "--fixed-in"):
        assert word in text
    assert max(map(len, text.splitlines())) <= 84


def test_json_is_alone_on_standard_output(box: Box, tmp_path: Path) -> None:
    process = start("mesh-to-modes", box.path, "--count", "7", "--json", cwd=tmp_path)
    status, out, err = finish(process)
    assert status == 0, err
    assert out.count("\n") == 1
    assert strict_json(out)["rigid_modes"] == 6
    assert err == "note: no --fixed: the body is free to move as a whole\n"


PRINTING = """
import ctypes, os, subprocess, sys
from fenics_defo.cli.output import libraries_on_stderr
with libraries_on_stderr():
    ctypes.CDLL(None).puts(b"from C")
    print("from Python")
    subprocess.run([sys.executable, "-c", "print('from a child')"])
print("ours")
"""


def test_libraries_cannot_write_to_standard_output() -> None:
    done = subprocess.run([sys.executable, "-c", PRINTING], capture_output=True, text=True)
    assert done.stdout == "ours\n"
    assert sorted(done.stderr.splitlines()) == ["from C", "from Python", "from a child"]


def test_a_reader_that_leaves_early(box: Box, tmp_path: Path) -> None:
    process = start("mesh-to-modes", box.path, "--fixed", "wall", "--count", "3", cwd=tmp_path)
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    status, _, err = finish(process)
    assert (status, err) == (128 + signal.SIGPIPE, "")
    assert (tmp_path / "modes.npz").exists()


def test_a_full_disk_behind_standard_output(modes_json: Any, folder: Path) -> None:
    modes_json("--fixed", "wall", "--count", "1")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", COMMANDS["fenics-defo"], "info", "modes.npz"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            timeout=60,
        )
    assert done.returncode == 1
    assert re.fullmatch("fenics-defo: <stdout>: cannot be written.*No space.*\n", done.stderr)


def test_file_names_that_the_locale_cannot_write(box: Box, tmp_path: Path) -> None:
    mesh = tmp_path / "Körper.msh"
    mesh.write_bytes(box.path.read_bytes())
    c_locale = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    status, out, err = finish(start("fenics-defo", "info", mesh, cwd=tmp_path, **c_locale))
    assert status == 0, err
    assert "rper.msh" in out


INTERRUPTED = "mesh-to-modes: interrupted; no file is left half-written\n"


@pytest.mark.parametrize("phase", ["read", "assemble", "write"])
def test_interrupted_in_the_middle(box: Box, tmp_path: Path, phase: str) -> None:
    """The process stops itself where it is told to, so that the signal always finds it there."""
    code = (
        "import os, signal, sys\n"
        "from fenics_defo.cli import progress, mesh_to_modes\n"
        "def start(self, name):\n"
        f"    if name == {phase!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "progress.Progress.start = start\n"
        f"sys.exit(mesh_to_modes.main([{str(box.path)!r}, '--fixed', 'wall', '--count', '2']))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", INTERRUPTED)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_that_a_library_swallows(box: Box, tmp_path: Path) -> None:
    code = (
        "import os, signal, sys\n"
        "from fenics_defo.cli import progress, mesh_to_modes\n"
        "def start(self, name):\n"
        "    try:\n"
        "        if name == 'build': os.kill(os.getpid(), signal.SIGINT)\n"
        "    except BaseException: pass\n"
        "progress.Progress.start = start\n"
        f"sys.exit(mesh_to_modes.main([{str(box.path)!r}, '--fixed', 'wall', '--count', '2']))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", INTERRUPTED)
    assert list(tmp_path.iterdir()) == []


def test_interrupted_while_kernels_compile(box: Box, tmp_path: Path) -> None:
    """A kernel that is half compiled would make the next run wait for it, and fail."""
    cache = tmp_path / "cache"
    process = start(
        "mesh-to-modes", box.path, "--fixed", "wall", cwd=tmp_path, XDG_CACHE_HOME=str(cache)
    )
    deadline = time.monotonic() + 60.0
    while not list(cache.glob("fenics/libffcx*.c")) and time.monotonic() < deadline:
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    status, out, err = finish(process)
    # Python itself ends by the signal, for shells the same 130, if Ctrl-C came within an exec().
    assert status in (130, -signal.SIGINT)
    assert (out, err) == ("", INTERRUPTED)
    locks = {path.stem for path in cache.glob("fenics/libffcx*.c")}
    assert locks == {path.name.partition(".")[0] for path in cache.glob("fenics/*.c.cached")}
    assert not (tmp_path / "modes.npz").exists()


def on_terminal(*command: str, keys: list[tuple[str, str]], cwd: Path) -> tuple[int, str]:
    """Run a command on a terminal; after each text is seen, its answer is typed."""
    terminal, theirs = pty.openpty()
    process = subprocess.Popen(
        command, cwd=cwd, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80"},
    )  # fmt: skip
    os.close(theirs)
    seen, waiting = "", list(keys)
    while True:
        try:
            data = os.read(terminal, 4096)
        except OSError:  # Linux's end of file for a terminal whose other side is closed
            break
        if not data:
            break
        seen += data.decode(errors="replace")
        if waiting and waiting[0][0] in seen:
            os.killpg(process.pid, signal.SIGINT) if waiting[0][1] == "^C" else None
            waiting.pop(0)
    os.close(terminal)
    assert not waiting, seen
    return process.wait(timeout=60.0), seen


def test_progress_and_style_on_a_terminal(box: Box, tmp_path: Path) -> None:
    command = [sys.executable, "-m", COMMANDS["mesh-to-modes"], str(box.path), "--count", "7"]
    status, seen = on_terminal(*command, keys=[("load", "")], cwd=tmp_path)
    assert status == 0, seen
    assert "\x1b[1m" in seen  # the heading is bold
    assert "note: no --fixed" in seen
    assert seen.rindex("\x1b[?25l") < seen.rindex("\x1b[?25h")  # the cursor is shown again
    shown_last = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", seen[seen.rindex("\x1b[?25h") :])
    assert "written: modes.npz" in shown_last


def test_the_display_says_that_it_stops(tmp_path: Path) -> None:
    code = (
        "import signal, sys, time\n"
        "from fenics_defo.cli.progress import Progress\n"
        "signal.signal(signal.SIGINT, signal.SIG_IGN)  # as during a long call of PETSc\n"
        "progress = Progress(show=True)\n"
        "progress.start('factorise')\n"
        "time.sleep(60)\n"
    )
    keys = [("factorise", "^C"), ("Ctrl-C again", "^C")]
    begin = time.monotonic()
    status, seen = on_terminal(sys.executable, "-c", code, keys=keys, cwd=tmp_path)
    assert status == -signal.SIGKILL
    assert time.monotonic() - begin < 30.0
    assert seen.rindex("\x1b[?25l") < seen.rindex("\x1b[?25h")


def test_a_display_that_dies_does_no_harm(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = subprocess.Popen(["true"], stdin=subprocess.PIPE, text=True)
    gone.wait()
    monkeypatch.setattr(progress, "can_style", lambda stream: True)
    monkeypatch.setattr(progress, "_start_ticker", lambda: gone)
    with progress.progress_shown(show=True) as shown:
        shown.start("solve")
        shown.note("still here")
    assert capsys.readouterr().err == "note: still here\n"


@pytest.mark.mpi
def test_two_ranks_print_once_and_agree(mpirun: Any, box: Box, tmp_path: Path) -> None:
    arguments = [box.path, "--fixed", "wall", "--count", "3", "--json"]
    alone = finish(start("mesh-to-modes", *arguments, cwd=tmp_path))
    both = mpirun("-m", COMMANDS["mesh-to-modes"], *arguments, "--vtk", "m.vtu", cwd=tmp_path)
    assert both.returncode == 0, both.stderr
    one, two = strict_json(alone[1]), strict_json(both.stdout)
    assert two["frequencies_hz"] == pytest.approx(one["frequencies_hz"], rel=1e-8)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.vtu", "modes.npz"]


@pytest.mark.mpi
@pytest.mark.parametrize(
    "arguments",
    [["--count", "0"], ["--fixed", "tip"], ["--output", "nowhere/a.npz"]],
)
def test_two_ranks_fail_with_one_sentence(
    mpirun: Any, box: Box, tmp_path: Path, arguments: list[str]
) -> None:
    done = mpirun("-m", COMMANDS["mesh-to-modes"], box.path, *arguments, cwd=tmp_path, timeout=60)
    assert done.returncode == 1
    assert done.stdout == ""
    assert re.fullmatch(r"mesh-to-modes: [^\n]+\n", done.stderr)


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("error", "status", "words"),
    [("ZeroDivisionError('ours')", 1, "ZeroDivisionError: ours"), ("OSError('his')", 1, "his")],
)
def test_a_fault_on_one_rank_ends_the_other(
    mpirun: Any, box: Box, tmp_path: Path, error: str, status: int, words: str
) -> None:
    code = (
        "import sys\n"
        "from fenics_defo.cli import mesh_to_modes, modes_run, ranks\n"
        "from fenics_defo.fem.compat import MPI\n"
        "ranks._PATIENCE = 0.5\n"
        "def faulty(*_, **__):\n"
        f"    if MPI.COMM_WORLD.rank == 1: raise {error}\n"
        "    MPI.COMM_WORLD.barrier()\n"
        "modes_run.linear_modes = faulty\n"
        f"sys.exit(mesh_to_modes.main([{str(box.path)!r}, '--fixed', 'wall']))\n"
    )
    done = mpirun("-c", code, cwd=tmp_path, timeout=60)
    assert done.returncode == status
    assert words in done.stderr
    assert list(tmp_path.iterdir()) == []
