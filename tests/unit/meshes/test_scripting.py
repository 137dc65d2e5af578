"""The session, the writing and the command line that the geometry scripts share."""

import os
import re
import subprocess
import sys
from pathlib import Path

import gmsh
import pytest

from meshes import bent_beam, cantilever, modelling, scripting, sphere

FOLDER = Path(scripting.__file__).parent


def run_script(script: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run meshes/<script> as a user does, with nothing of the project on the module path."""
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, str(FOLDER / script), *arguments]
    return subprocess.run(command, cwd=cwd, env=bare, capture_output=True, text=True, check=False)


def test_a_script_writes_where_it_is_told(tmp_path: Path) -> None:
    done = run_script("cantilever.py", "--size", "0.1", "--cell", "hexahedron", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("\n") == 1
    assert "44 nodes, 132 dofs, 10 cells" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["cantilever.msh"]


def test_a_script_says_what_is_wrong_in_one_sentence(tmp_path: Path) -> None:
    done = run_script("sphere.py", "--size", "nan", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == ("sphere.py: size is nan m; give a positive, finite length in metres.\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("module", sorted(path.stem for path in FOLDER.glob("*.py")))
def test_every_body_is_named_like_its_module(module: str) -> None:
    source = (FOLDER / f"{module}.py").read_text(encoding="utf-8")
    shared = module in {"__init__", "modelling", "scripting"}
    assert (f"raise SystemExit(scripting.run({module}))" in source) != shared


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--size", "-1"], "size is -1.0 m"),
        (["--size", "inf"], "size is inf m"),
        (["--size", "1e-9"], "at most 2e\\+07 are made"),
        (["--radius", "0"], "radius is 0.0 m"),
        (["-o", "missing/ball.msh"], "cannot write missing/ball.msh"),
        (["-o", "ball.png"], "ending must be one of .msh"),
        (["-o", "ball"], "ending must be one of .msh"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str],
    complaint: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert scripting.run(sphere.sphere, arguments) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert re.search(complaint, said.err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("arguments", [["--size", "wide"], ["--order", "3"], ["--colour", "red"]])
def test_a_malformed_command_line_is_one_sentence(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        scripting.run(sphere.sphere, arguments)
    assert stop.value.code == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_too_many_regular_cells_are_refused() -> None:
    with pytest.raises(modelling.MeshScriptError, match="100,000th"):
        modelling.divisions(1.0, 1.0e-300)
    with (
        pytest.raises(modelling.MeshScriptError, match="at most"),
        scripting.built(cantilever.cantilever, size=1.0e-4),
    ):
        pass


def test_a_bend_without_an_inner_side_is_refused() -> None:
    with (
        pytest.raises(modelling.MeshScriptError, match="more than height"),
        scripting.built(bent_beam.bent_beam, radius=0.05, height=0.1),
    ):
        pass


@pytest.mark.parametrize(("length", "size", "count"), [(0.3, 0.1, 3), (0.31, 0.1, 4), (1.0, 9, 1)])
def test_divisions(length: float, size: float, count: int) -> None:
    assert modelling.divisions(length, size) == count


def test_the_same_arguments_give_the_same_file(tmp_path: Path) -> None:
    first, second = tmp_path / "first.msh", tmp_path / "second.msh"
    scripting.write(sphere.sphere, first, size=0.3)
    gmsh.initialize(interruptible=False)
    try:  # inside a session that someone has set up otherwise, and after other work
        gmsh.option.setNumber("Mesh.Algorithm3D", 1)
        gmsh.option.setNumber("Mesh.MeshSizeFactor", 0.5)
        with scripting.built(cantilever.cantilever, size=0.2):
            pass
        scripting.write(sphere.sphere, second, size=0.3)
    finally:
        gmsh.finalize()
    assert first.read_bytes() == second.read_bytes()


def test_an_open_session_is_left_as_it_was() -> None:
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.125)
        gmsh.model.add("mine")
        gmsh.model.occ.addBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
        gmsh.model.occ.synchronize()
        before = gmsh.model.list(), gmsh.model.getEntities()
        with scripting.built(sphere.sphere, size=0.5):
            assert gmsh.model.getCurrent() != "mine"
        with (
            pytest.raises(modelling.MeshScriptError),
            scripting.built(sphere.sphere, size=-1.0),
        ):
            pass
        assert gmsh.model.getCurrent() == "mine"
        assert (gmsh.model.list(), gmsh.model.getEntities()) == before
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 0.125
    finally:
        gmsh.finalize()


def test_no_session_is_left_behind() -> None:
    with scripting.built(sphere.sphere, size=0.5):
        assert gmsh.isInitialized()
    assert not gmsh.isInitialized()


@pytest.mark.parametrize("suffix", scripting.FORMATS)
def test_every_promised_format_is_written(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"beam{suffix}"
    summary = scripting.write(cantilever.cantilever, path, size=0.1)
    assert path.stat().st_size > 20 * summary.nodes
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_the_file_holds_the_named_groups(version: float, tmp_path: Path) -> None:
    path = tmp_path / "beam.msh"
    summary = scripting.write(cantilever.cantilever, path, size=0.1, format_version=version)
    assert path.read_text(encoding="utf-8").startswith(f"$MeshFormat\n{version} 0 8")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        names = [gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()]
        assert tuple(names) == summary.groups
        assert len(gmsh.model.mesh.getNodes()[0]) == summary.nodes
    finally:
        gmsh.finalize()


def test_an_existing_file_survives_a_failure(tmp_path: Path) -> None:
    path = tmp_path / "ball.msh"
    path.write_text("precious", encoding="utf-8")
    with pytest.raises(modelling.MeshScriptError):
        scripting.write(sphere.sphere, path, size=-1.0)
    assert path.read_text(encoding="utf-8") == "precious"
    scripting.write(sphere.sphere, path, size=0.5)
    assert path.read_text(encoding="utf-8").startswith("$MeshFormat")
