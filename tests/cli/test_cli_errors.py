"""What users get wrong: one sentence that helps, exit status 1, no traceback, no file."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from cli_files import Box

from fenics_defo.cli import defo, mesh_to_modes

Captured = pytest.CaptureFixture[str]


def said(err: str, command: str = "mesh-to-modes") -> str:
    """The one sentence on standard error, without the name of the command."""
    assert err.endswith("\n")
    assert err.count("\n") == 1, err
    name, _, sentence = err.rstrip("\n").partition(": ")
    assert name == command
    return sentence


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--fixed tip", "'tip'.*'wall' .5.*'near' .7.*'far' .8"),
        ("--fixed 99", "no group 99"),
        ("--fixed x>5", "matches no node.*0 <= x <= 4"),
        ("--fixed x>", "column 3"),
        ("--fixed nodes:none.bou", "none.bou"),
        ("--fixed-in w x==0", "'x', 'y', 'z', got 'w'"),
        ("--fixed-in x", "expected 2 arguments"),
        ("--free --fixed wall", "--free and --fixed exclude"),
        ("--free --fixed-in x wall", "--free and --fixed exclude"),
        ("--count 0", "whole number from 1, got '0'"),
        ("--count -2", "whole number from 1, got '-2'"),
        ("--count 1.5", "whole number from 1, got '1.5'"),
        ("--count 1000", "243.*1000"),
        ("--order 3", "--order"),
        ("--young nan", "young must be positive.*nan"),
        ("--young soft", "--young: must be a number, got 'soft'"),
        ("--poisson 0.5", "poisson must lie .*0.5"),
        ("--density -1", "density must be positive.*-1"),
        ("--size 0", "--size"),
        ("--merge nan", "--merge"),
        ("--materials none.toml", "none.toml"),
        ("--materials none.toml --young 1e9", "--materials and --young exclude"),
        ("--output nowhere/modes.npz", "folder .*nowhere"),
        ("--output .", "is a folder"),
        ("--output modes.txt", "writes an .npz file, got the name modes.txt"),
        ("--vtk modes.stl", "modes.stl.*.vtu"),
        ("--picture modes.jpg", "modes.jpg.*png"),
        ("--output modes.vtu --vtk ./modes.vtu", "--vtk and --output name the same file"),
        ("--solver magic", "davidson"),
        ("--frobnicate", "--frobnicate.*--help"),
        ("--coun 3", "--coun"),
    ],
)
def test_one_sentence_for_each_mistake(
    folder: Path, box: Box, capsys: Captured, options: str, words: str
) -> None:
    assert mesh_to_modes.main([str(box.path), *options.split()]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.search(words, said(err))
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("command", [mesh_to_modes.main, lambda argv: defo.main(["info", *argv])])
@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.msh", None, "none.msh does not exist"),
        ("empty.msh", "", "empty.msh is empty"),
        ("notes.txt", "no mesh", "notes.txt.*.msh"),
        ("broken.msh", "$MeshFormat\n2.2 0 8\n", "broken.msh"),
        ("surface.stl", "solid s\nendsolid s\n", "surface.stl"),
    ],
)
def test_files_that_are_no_mesh(folder: Path, capsys: Captured, command, name, content, words):
    if content is not None:
        (folder / name).write_text(content)
    assert command([name]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.search(words, said(err, err.partition(":")[0]))


def test_the_mesh_is_not_overwritten(folder: Path, box: Box, capsys: Captured) -> None:
    before = box.path.read_bytes()
    assert mesh_to_modes.main([str(box.path), "--output", str(box.path)]) == 1
    assert "--output and MESH name the same file" in said(capsys.readouterr().err)
    assert box.path.read_bytes() == before


def test_no_arguments(capsys: Captured) -> None:
    assert mesh_to_modes.main([]) == 1
    assert "MESH" in said(capsys.readouterr().err)
    assert defo.main([]) == 1
    assert "COMMAND" in said(capsys.readouterr().err, "fenics-defo")


def test_our_own_faults_keep_their_traceback(
    folder: Path, box: Box, monkeypatch: pytest.MonkeyPatch
) -> None:
    def faulty(*_: object, **__: object) -> None:
        raise ZeroDivisionError("ours")

    monkeypatch.setattr("fenics_defo.cli.modes_run.linear_modes", faulty)
    with pytest.raises(ZeroDivisionError, match="ours"):
        mesh_to_modes.main([str(box.path), "--fixed", "wall"])
    assert list(folder.iterdir()) == []


def test_too_little_memory(
    folder: Path, box: Box, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    def greedy(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("fenics_defo.cli.modes_run.linear_modes", greedy)
    assert mesh_to_modes.main([str(box.path), "--fixed", "wall"]) == 1
    assert "coarser mesh" in said(capsys.readouterr().err)


HIDE = """
import sys
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
HIDDEN = {hidden!r}
sys.meta_path.insert(0, Hidden())
import fenics_defo.cli.mesh_to_modes
sys.exit(fenics_defo.cli.mesh_to_modes.main({arguments!r}))
"""


@pytest.mark.parametrize(
    ("library", "words"),
    [
        ("dolfinx", r"fenics_defo\[fem\]"),
        ("gmsh", r"gmsh.*fenics_defo\[fem\]"),
        ("pyvista", r"fenics_defo\[view\]"),
    ],
)
def test_what_is_not_installed(folder: Path, box: Box, library: str, words: str) -> None:
    arguments = [str(box.path), "--fixed", "wall", "--count", "1", "--picture", "a.png"]
    code = HIDE.replace("{hidden!r}", repr({library})).replace("{arguments!r}", repr(arguments))
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1, done.stderr
    assert re.search(words, said(done.stderr))
    assert list(folder.iterdir()) == []
