"""A mesh file and a folder to work in, for each test of the commands."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cli_files import Box, strict_json, write_box

from fenics_defo.cli import mesh_to_modes


@pytest.fixture(scope="session")
def box(tmp_path_factory: pytest.TempPathFactory) -> Box:
    return write_box(tmp_path_factory.mktemp("box") / "box.msh")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def modes_json(
    folder: Path, box: Box, capsys: pytest.CaptureFixture[str]
) -> Callable[..., dict[str, Any]]:
    """Run ``mesh-to-modes box.msh ARGUMENTS --json`` in this process and return its object."""

    def compute(*arguments: str) -> dict[str, Any]:
        status = mesh_to_modes.main([str(box.path), *arguments, "--json"])
        out, err = capsys.readouterr()
        assert status == 0, err
        return strict_json(out)

    return compute
