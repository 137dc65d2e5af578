"""Files that the tests of the commands read: a box of hexahedra as Gmsh writes it, by hand."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LENGTH, WIDTH, HEIGHT = 4.0, 1.0, 0.5
DIVISIONS = (8, 2, 2)
FIRST_NUMBER = 11  # nodes are numbered 11, 14, 17, ...: no row of an array
NUMBER_STEP = 3

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7850.0}
COMMANDS = {"mesh-to-modes": "fenics_defo.cli.mesh_to_modes", "fenics-defo": "fenics_defo.cli.defo"}

SCENE = """
[mesh]
file = "{mesh}"
[[material]]
law = "st-venant-kirchhoff"
young = 1e7
poisson = 0.3
density = 1000
[[fixed]]
region = "wall"
[[load]]
kind = "gravity"
[damping]
stiffness = 1e-3
[time]
integrator = "implicit-newmark"
step = 0.01
duration = 0.1
[[probe]]
name = "tip"
point = [4, 0.3, 0.5]
"""


@dataclass(frozen=True)
class Box:
    """A box with the groups ``wall`` (facets at x = 0), ``near`` and ``far`` (cells)."""

    path: Path
    points: NDArray[np.float64]
    cells: NDArray[np.int64]

    @property
    def numbers(self) -> NDArray[np.int64]:
        return FIRST_NUMBER + NUMBER_STEP * np.arange(len(self.points))


def write_box(path: Path) -> Box:
    """Write a Gmsh file (2.2, text) whose nodes and cells are in an order of their own."""
    axes = [
        np.linspace(0.0, size, n + 1)
        for size, n in zip((LENGTH, WIDTH, HEIGHT), DIVISIONS, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(grid)).reshape([n + 1 for n in DIVISIONS])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1)]
    i, j, k = np.meshgrid(*[np.arange(n) for n in DIVISIONS], indexing="ij")
    cells = np.stack([index[i + a, j + b, k + c] for a, b, c in [*corners, (0, 1, 1)]], axis=-1)
    cells = cells.reshape(-1, 8)
    order = np.random.default_rng(1).permutation(len(grid))  # new row -> grid point
    row = np.argsort(order)
    box = Box(path, grid[order], row[cells][::-1])
    j, k = np.meshgrid(*[np.arange(n) for n in DIVISIONS[1:]], indexing="ij")
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    facets = row[np.stack([index[0, j + b, k + c] for b, c in square], axis=-1).reshape(-1, 4)]
    path.write_text(_gmsh_text(box, facets))
    return box


def _gmsh_text(box: Box, facets: NDArray[np.int64]) -> str:
    middles = box.points[box.cells].mean(axis=1)
    elements = [f"3 2 5 1 {_join(box.numbers[facet])}" for facet in facets]
    for cell, middle in zip(box.cells, middles, strict=True):
        group = 7 if middle[0] < LENGTH / 2 else 8
        elements.append(f"5 2 {group} 1 {_join(box.numbers[cell])}")
    nodes = [f"{n} {_join(x)}" for n, x in zip(box.numbers, box.points.tolist(), strict=True)]
    sections = {
        "MeshFormat": ["2.2 0 8"],
        "PhysicalNames": ["3", '2 5 "wall"', '3 7 "near"', '3 8 "far"'],
        "Nodes": [str(len(nodes)), *nodes],
        "Elements": [str(len(elements)), *(f"{n + 1} {e}" for n, e in enumerate(elements))],
    }
    return "".join(f"${k}\n" + "\n".join(v) + f"\n$End{k}\n" for k, v in sections.items())


def _join(values: Any) -> str:
    return " ".join(map(str, values))


def start(command: str, *arguments: str | Path, cwd: Path, **more: str) -> subprocess.Popen[str]:
    """Start a command as a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", COMMANDS[command], *map(str, arguments)],
        cwd=cwd,
        env={**os.environ, **more},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process: subprocess.Popen[str], *, timeout: float = 60.0) -> tuple[int, str, str]:
    """Return exit status, standard output and standard error."""
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.communicate()
        raise
    return process.returncode, out, err


def strict_json(text: str) -> dict[str, Any]:
    """Read one JSON object; NaN and infinities, which are no JSON, are refused."""

    def refuse(constant: str) -> float:
        raise ValueError(f"{constant} is no JSON")

    value = json.loads(text, parse_constant=refuse)
    assert isinstance(value, dict)
    return value
