"""What the README and docs/ show is what happens: their blocks run as they stand."""

import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from fenics_defo.cli import defo, mesh_to_modes
from meshes.scripting import write
from meshes.tuning_fork import tuning_fork

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [
    ROOT / "README.md",
    *sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts),
]
#: Pages whose commands are run too, not only understood.
TOURS = [DOCS / "first_hour.md"]
PARSERS = {"mesh-to-modes": mesh_to_modes.build_parser, "fenics-defo": defo.build_parser}
SESSION = Path(__file__).with_name("page_session.py")


class Block(NamedTuple):
    """A fenced block: its language, its text, and the page and line where it begins."""

    language: str
    text: str
    page: Path
    line: int


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    found = re.finditer(r"^```(\S*)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    return [Block(m[1], m[2], page, text.count("\n", 0, m.start()) + 1) for m in found]


def lines(block: Block) -> list[str]:
    """Commands, each in one line."""
    return [line for line in block.text.replace("\\\n", " ").splitlines() if line.strip()]


BLOCKS = [block for page in PAGES for block in blocks(page)]
COMMANDS = [
    (f"{block.page.name}:{block.line}", line)
    for block in BLOCKS
    if block.language == "sh"
    for line in lines(block)
]
SHOWING = [page for page in PAGES if any(b.language == "python" for b in BLOCKS if b.page == page)]


def steps(page: Path) -> list[tuple[str, str, int, str]]:
    """What a reader does on a page: kind, page, line, text."""
    done: list[tuple[str, str, int, str]] = []
    for block in blocks(page):
        place = (str(page.relative_to(ROOT)), block.line)
        if block.language == "python":
            done.append(("python", *place, block.text))
        elif page in TOURS and block.language == "toml":
            done.append(("save", *place, block.text))
        elif page in TOURS and block.language == "sh":
            done += [("run", *place, line) for line in lines(block)]
    return done


@pytest.fixture
def folder(page: Path, tmp_path: Path) -> Path:
    """A folder with what the page speaks of; the mesh of the demo is coarser."""
    if "demo/" in page.read_text(encoding="utf-8"):
        (tmp_path / "demo").mkdir()
        write(tuning_fork, tmp_path / "demo" / "tuning_fork.msh", size=4e-3)
    for name in ("meshes", "scenes"):
        (tmp_path / name).symlink_to(ROOT / name)
    return tmp_path


def test_the_pages_have_examples() -> None:
    assert len(SHOWING) >= 6
    assert len(COMMANDS) >= 15
    assert all(any(kind == "run" for kind, *_ in steps(page)) for page in TOURS)


def test_each_block_names_a_known_language() -> None:
    """A block in a language that nothing here looks at would be shown unchecked."""
    known = {"python", "sh", "toml", "text", "{eval-rst}", "{toctree}"}
    assert [(b.page.name, b.line) for b in BLOCKS if b.language not in known] == []


@pytest.mark.parametrize(
    "page",
    [pytest.param(p, marks=pytest.mark.slow) if p in TOURS else p for p in SHOWING],
    ids=[str(p.relative_to(ROOT)) for p in SHOWING],
)
def test_pages_run(page: Path, folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", SESSION],
        input=json.dumps(steps(page)),
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip(), page


@pytest.mark.parametrize(("place", "line"), COMMANDS)
def test_commands_are_understood(place: str, line: str) -> None:
    words = shlex.split(line, comments=True)
    if words[0] == "make":
        makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
        for target in (word for word in words[1:] if "=" not in word):
            assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE), place
    for at, word in enumerate(words):
        if word.startswith(".venv/bin/") and Path(word).name in PARSERS:
            assert PARSERS[Path(word).name]().parse_args(words[at + 1 :]), place
            break
    else:
        assert words[0] in ("make", "apt-get", "conda", "pip", "python3", ".venv/bin/python"), place


@pytest.mark.parametrize(
    "block", [b for b in BLOCKS if b.language == "toml"], ids=lambda b: f"{b.page.name}:{b.line}"
)
def test_toml_is_toml(block: Block) -> None:
    assert tomllib.loads(block.text)


def test_links_lead_somewhere() -> None:
    missing = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in PAGES
        for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
        if "://" not in target and not (page.parent / target.partition("#")[0]).exists()
    ]
    assert missing == []
