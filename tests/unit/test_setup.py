"""What `make` does before anything of ours can be imported: tools/, constraints.txt."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIND_PYTHON = ROOT / "tools" / "find_python.sh"


def read_check_system() -> ModuleType:
    path = ROOT / "tools" / "check_system.py"
    spec = importlib.util.spec_from_file_location("check_system", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


check_system = read_check_system()


class Machine:
    """A PATH and a home folder that hold only the commands which a test puts there."""

    def __init__(self, folder: Path) -> None:
        self.bin = folder / "bin"
        self.home = folder / "home of mine"
        self.bin.mkdir()
        self.home.mkdir()
        for tool in ("dirname", "id", "sort", "sh"):
            found = shutil.which(tool)
            assert found is not None
            (self.bin / tool).symlink_to(found)

    def add(self, path: Path | str, script: str) -> Path:
        """Put a shell script at ``path``, relative to the folder of commands."""
        command = self.bin / path
        command.parent.mkdir(parents=True, exist_ok=True)
        command.write_text(f"#!/bin/sh\n{script}\n")
        command.chmod(0o755)
        return command

    def find(self, **variables: str) -> subprocess.CompletedProcess[str]:
        environment = {"PATH": str(self.bin), "HOME": str(self.home), **variables}
        command = [shutil.which("sh") or "sh", str(FIND_PYTHON)]
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, check=False, timeout=30
        )


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


REAL = f'exec "{sys.executable}" "$@"'
BASE = str(getattr(sys, "_base_executable", sys.executable))
FAILING_SHIM = 'echo "pyenv: command not found" >&2; exit 127'
TOO_OLD = 'case "$2" in *platform*) echo "CPython 3.11.7" ;; *) exit 3 ;; esac'


def without_venv(path: Path) -> str:
    """A Python like Debian's without python3-venv, at ``path``: it runs but has no ensurepip."""
    return f'case "$2" in *ensurepip*) exit 1 ;; *) echo "{path}" ;; esac'


def test_a_shim_that_fails_is_passed_over(machine: Machine) -> None:
    machine.add("python3.14", FAILING_SHIM)
    machine.add("python3.13", FAILING_SHIM)
    machine.add("python3.12", REAL)
    done = machine.find()
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, BASE, "")


def test_python3_is_taken_when_new_enough(machine: Machine) -> None:
    machine.add("python3", REAL)
    assert machine.find().stdout.strip() == BASE


@pytest.mark.parametrize("variable", [True, False])
def test_pyenv_folder_newest_first(machine: Machine, variable: bool) -> None:
    root = machine.home / ("elsewhere" if variable else ".pyenv")
    machine.add("python3", TOO_OLD)
    machine.add(root / "versions/3.9.18/bin/python3", TOO_OLD)
    machine.add(root / "versions/3.12.9/bin/python3", "exit 1")
    newest = root / "versions/3.12.10/bin/python3"
    machine.add(newest, f'case "$2" in *ensurepip*) ;; *) echo "{newest}" ;; esac')
    done = machine.find(**({"PYENV_ROOT": str(root)} if variable else {}))
    assert done.stdout.strip() == str(newest)


def test_uv_is_asked_last(machine: Machine) -> None:
    python = machine.add(machine.home / "python", REAL)
    machine.add("uv", f'case "$*" in "python find"*) echo "{python}" ;; *) exit 2 ;; esac')
    assert machine.find().stdout.strip() == BASE


def test_uv_that_cannot_download_ends_in_one_sentence(machine: Machine) -> None:
    machine.add("uv", "exit 2")
    done = machine.find()
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("No Python 3.12 or newer was found")


def test_a_python_without_venv_is_the_last_resort(machine: Machine) -> None:
    bare = machine.add("python3.13", without_venv(machine.bin / "python3.13"))
    assert machine.find().stdout.strip() == str(bare)
    machine.add("python3.12", REAL)
    assert machine.find().stdout.strip() == BASE


def test_no_python_at_all(machine: Machine) -> None:
    machine.add("python3", TOO_OLD)
    done = machine.find()
    assert (done.returncode, done.stdout) == (1, "")
    assert len(done.stderr.splitlines()) == 1
    assert "apt-get install python3 python3-venv python3-dev" in done.stderr
    assert "uv python install 3.12" in done.stderr


def test_the_given_python_is_used(machine: Machine) -> None:
    machine.add("python3.14", "exit 1")
    mine = machine.add(machine.home / "my python", REAL)
    assert machine.find(PYTHON=str(mine)).stdout.strip() == BASE


@pytest.mark.parametrize(
    ("script", "reason"), [(TOO_OLD, "is CPython 3.11.7"), (FAILING_SHIM, "does not run")]
)
def test_the_given_python_is_never_replaced(machine: Machine, script: str, reason: str) -> None:
    machine.add("python3.12", REAL)
    mine = machine.add("mine", script)
    for given in (str(mine), "mine"):
        done = machine.find(PYTHON=given)
        assert (done.returncode, done.stdout) == (1, "")
        assert f"PYTHON={given} {reason}" in done.stderr


def test_missing_libraries_name_their_packages() -> None:
    asked = {"libc.so.6": "libc6", "libNone.so.1": "libnone1", "libNil.so.2": "libnil2"}
    missing = check_system.missing_libraries(asked)
    assert missing == {"libNone.so.1": "libnone1", "libNil.so.2": "libnil2"}
    text = check_system.sentence(missing)
    assert len(text.splitlines()) == 1
    assert "apt-get install libnil2 libnone1`" in text
    assert "libNone.so.1, libNil.so.2" in text


def test_a_missing_package_and_a_python_of_ones_own() -> None:
    text = check_system.sentence({"Python.h": "", "libNone.so.1": "libnone1"})
    assert "apt-get install libnone1`" in text
    assert "PYTHON=/path/to/python3" in text


def test_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "/nowhere/cc -pipe")
    (thing,) = check_system.missing_build_tools()
    assert thing == "a C compiler that works (/nowhere/cc)"
    assert check_system.missing_build_tools()[thing] == "gcc libc6-dev"


def test_this_machine_lacks_nothing() -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "tools" / "check_system.py")],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_every_library_of_gmsh_is_checked() -> None:
    """What gmsh's ELF header asks for is in the list or belongs to the C library itself."""
    library = next(Path(sys.prefix, "lib").glob("libgmsh.so*"), None)
    if library is None:  # not from the wheel: then the system's packages see to it
        assert importlib.util.find_spec("gmsh") is not None
        return
    text = library.read_bytes()[: 1 << 22].decode("latin-1")
    named = set(re.findall(r"\x00(lib(?:X|GL|EGL|fontconfig|gomp|z\.)[\w+-]*\.so\.\d+)\x00", text))
    assert {"libGLU.so.1", "libXft.so.2"} <= named
    assert named <= set(check_system.LIBRARIES)


def test_a_module_that_does_not_load(capsys: pytest.CaptureFixture[str]) -> None:
    assert check_system.failed_loads(("math",)) == {}
    (error,) = check_system.failed_loads(("no_such_module",)).values()
    assert "no_such_module" in error


def pinned() -> dict[str, str]:
    text = (ROOT / "constraints.txt").read_text()
    return dict(re.findall(r"^([a-z0-9-]+)==(\S+)", text, flags=re.MULTILINE))


def test_the_lock_covers_what_pyproject_asks_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    asked = [*project["project"]["dependencies"], *project["build-system"]["requires"]]
    asked += [requirement for extra in extras.values() for requirement in extra]
    names = {re.match(r"[A-Za-z0-9_.-]+", one).group().lower().replace("_", "-") for one in asked}
    assert names - {"fenics-defo"} <= set(pinned())


def test_the_lock_tells_nothing_of_the_machine_it_was_made_on() -> None:
    text = (ROOT / "constraints.txt").read_text()
    assert not re.search(r"://|(^|\s)/|--(extra-)?index|--find-links|(^|\n)-", text)


def test_make_env_refuses_a_venv_that_is_not_its_own(tmp_path: Path) -> None:
    project = tmp_path / "a project"
    shutil.copytree(ROOT / "tools", project / "tools")
    for name in ("pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, project / name)
    (project / ".venv").mkdir()
    (project / ".venv" / "precious").touch()
    done = subprocess.run(
        ["sh", str(project / "tools" / "make_env.sh")],
        env={**os.environ, "PYTHON": sys.executable},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 1
    assert "was not made by make" in done.stderr
    assert [path.name for path in (project / ".venv").iterdir()] == ["precious"]
