"""What every test relies on: an environment of its own, set before anything numerical is imported.

Compiled kernels are kept in ``.cache/tests`` of the project, so that a second run need not compile
and that the user's own cache and settings are neither read nor written.
"""

import fcntl
import importlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Protocol

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
CACHE = ROOT / ".cache" / "tests"
KERNELS = CACHE / "fenics"

# A kernel takes half a second to compile, but several processes may wait for the one that does it.
JIT_OPTIONS = {"timeout": 300}

# A suite in the background of a shell ignores Ctrl-C, and so would the commands that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)


def isolate_environment() -> None:
    """Point every cache and setting of the libraries into the project."""
    options = CACHE / "config" / "dolfinx" / "dolfinx_jit_options.json"
    options.parent.mkdir(parents=True, exist_ok=True)
    draft = options.with_suffix(f".{os.getpid()}")
    draft.write_text(json.dumps(JIT_OPTIONS))
    draft.replace(options)  # at once, for another process may be reading it
    os.environ["XDG_CACHE_HOME"] = str(CACHE)
    os.environ["XDG_CONFIG_HOME"] = str(CACHE / "config")
    os.environ["MPLCONFIGDIR"] = str(CACHE / "matplotlib")
    os.environ.pop("PETSC_OPTIONS", None)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    # Found by the processes that tests start, in whatever folder, installed or not.
    paths = [str(ROOT), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(p for p in paths if p))


isolate_environment()
importlib.import_module("fenics_defo.fem.compat")  # MPI loads before a test imports PETSc

# The same examples on each run: a test that fails once in a hundred runs only teaches to run again.
settings.register_profile("repeatable", deadline=None, derandomize=True, database=None)
settings.load_profile("repeatable")


def drop_unfinished_kernels() -> IO[str]:
    """Remove kernels whose compilation was interrupted, for which a later run would wait in vain.

    A ``.c`` file without ``.c.cached`` is either that or being compiled right now; so this is done
    only when no other test run holds the shared lock, and by the first process alone.

    Returns:
        The open lock file: the lock lasts until it is closed.
    """
    KERNELS.mkdir(parents=True, exist_ok=True)
    lock = (CACHE / "lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        pass
    else:
        for source in KERNELS.glob("*.c"):
            if not source.with_suffix(".c.cached").exists():
                source.unlink()
    fcntl.flock(lock, fcntl.LOCK_SH)
    return lock


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):  # a worker of pytest-xdist has it
        config.add_cleanup(drop_unfinished_kernels().close)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Let one worker run all tests that start processes: their ranks wait busily for each other."""
    if config.pluginmanager.hasplugin("xdist"):
        for item in items:
            if item.get_closest_marker("mpi"):
                item.add_marker(pytest.mark.xdist_group("mpi"))


class MpiRun(Protocol):
    """Runs ``mpiexec -n RANKS python ARGUMENTS`` and returns what it printed."""

    def __call__(
        self,
        *arguments: str | Path,
        ranks: int = 2,
        timeout: float = 120.0,
        cwd: Path | None = None,
        env: Mapping[str, str] | None = None,
    ) -> subprocess.CompletedProcess[str]: ...


def end(process: subprocess.Popen[str]) -> tuple[str, str]:
    """End mpiexec and its ranks, which have sessions of their own: killing mpiexec orphans them."""
    process.send_signal(signal.SIGTERM)  # it ends its ranks then
    try:
        return process.communicate(timeout=10.0)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()


def run_ranks(
    *arguments: str | Path,
    ranks: int = 2,
    timeout: float = 120.0,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run this Python on several MPI ranks; see the fixture ``mpirun``."""
    beside = Path(sys.executable).with_name("mpiexec")  # the one of the MPI that DOLFINx links to
    mpiexec = str(beside) if beside.exists() else shutil.which("mpiexec")
    assert mpiexec is not None, f"no mpiexec beside {sys.executable} nor on PATH"
    command = [mpiexec, "-n", str(ranks), sys.executable, *map(str, arguments)]
    process = subprocess.Popen(
        command,
        cwd=cwd,
        env={**os.environ, **(env or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=timeout)
    except BaseException as reason:
        out, err = end(process)
        if isinstance(reason, subprocess.TimeoutExpired):
            pytest.fail(f"{ranks} ranks still ran after {timeout} s\n{out}\n{err}")
        raise
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@pytest.fixture(scope="session")
def mpirun() -> MpiRun:
    """``mpirun("-c", code)``, ``mpirun("-m", module, ...)``, ``mpirun(script, ...)`` on two ranks.

    Mark the test ``mpi``. Keywords: ``ranks``, ``timeout`` [s], ``cwd``, ``env`` (added to ours).
    """
    return run_ranks
