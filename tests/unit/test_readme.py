"""What the README and docs/ show is what happens: their Python blocks run as they stand."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from fenics_defo.cli.mesh_to_modes import build_parser
from meshes.scripting import write
from meshes.tuning_fork import tuning_fork

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(language: str) -> list[tuple[str, str]]:
    """(page and place, text) of each fenced block of a language."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in re.finditer(rf"```{language}\n(.*?)```", text, flags=re.DOTALL):
            line = text.count("\n", 0, match.start()) + 1
            found.append((f"{page.name}:{line}", match.group(1)))
    return found


PYTHON = blocks("python")
COMMANDS = [
    (place, line)
    for place, text in blocks("sh")
    for line in text.splitlines()
    if "bin/mesh-to-modes " in line
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the mesh that the pages speak of, coarser."""
    home = tmp_path_factory.mktemp("readme")
    (home / "demo").mkdir()
    write(tuning_fork, home / "demo" / "tuning_fork.msh", size=4e-3)
    (home / "scenes").symlink_to(ROOT / "scenes")
    return home


def test_the_pages_have_examples() -> None:
    assert len(PYTHON) >= 2
    assert len(COMMANDS) >= 3


@pytest.mark.parametrize(("place", "text"), PYTHON, ids=[place for place, _ in PYTHON])
def test_python_blocks_run(place: str, text: str, folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", text], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{place}: {done.stderr}"
    assert done.stdout.strip(), place


@pytest.mark.parametrize(("place", "line"), COMMANDS)
def test_commands_are_understood(place: str, line: str) -> None:
    words = shlex.split(line, comments=True)
    arguments = words[next(i for i, w in enumerate(words) if w.endswith("mesh-to-modes")) + 1 :]
    assert build_parser().parse_args(arguments).mesh, place
