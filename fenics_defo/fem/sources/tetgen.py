"""TetGen's pair of files, .node and .ele, counted from 0 or 1, tetrahedra of 4 or 10 nodes.

A line of .node is number, x, y, z, attributes, boundary markers; a line of .ele is number, nodes,
attributes; each file opens with its counts (TetGen manual, "File formats").
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.cell_shapes import TET_EDGES
from fenics_defo.fem.sources.keyword_text import Section, read_text
from fenics_defo.fem.sources.msh_cursor import whole
from fenics_defo.fem.sources.numbering import rows_of
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup, RawMesh

Integers = NDArray[np.int64]


def read_tetgen(path: Path) -> RawMesh:
    """Content of a .node and .ele pair, either of which is named.

    The first cell attribute (region) and the first node marker become groups; 0 means none.

    Raises:
        MeshError: a file is missing, damaged, or not three-dimensional.
    """
    node_path, cell_path = path.with_suffix(".node"), path.with_suffix(".ele")
    if path.suffix.isupper():
        node_path, cell_path = path.with_suffix(".NODE"), path.with_suffix(".ELE")
    for file in (node_path, cell_path):
        if not file.is_file():
            raise MeshError(f"{path}: its companion {file} is missing; put both in one folder")
    nodes, (dimension, attributes, markers) = _table(node_path, lambda n: 1 + n[1] + n[2] + n[3])
    if dimension != 3:
        raise MeshError(f"{node_path} holds points of dimension {dimension}; 3 is needed")
    cells, (corners, regions, _) = _table(cell_path, lambda n: 1 + n[1] + n[2])
    if corners not in (4, 10):
        raise MeshError(f"{cell_path} holds cells of {corners} nodes; 4 and 10 are read")
    numbers = whole(nodes[:, 0], str(node_path))
    wanted = whole(cells[:, 1 : 1 + corners], str(cell_path))
    rows = rows_of(wanted, numbers, what=str(cell_path), thing="node")
    points = np.ascontiguousarray(nodes[:, 1:4])
    if corners == 10:
        rows = _in_vtk_order(points, rows, cell_path)
    raised = int(numbers.min(initial=1) == 0)
    cell_numbers = whole(cells[:, 0], str(cell_path))
    block = CellBlock(
        cell_type="tetra" if corners == 4 else "tetra10",
        nodes=rows,
        numbers=cell_numbers + int(cell_numbers.min(initial=1) == 0),
    )
    raw = RawMesh(label=str(path), points=points, node_numbers=numbers + raised, blocks=[block])
    if raised:
        raw.notes.append("the files count nodes and cells from 0; here they count from 1.")
    if regions:
        raw.groups += _groups(cells[:, 1 + corners], 3, np.arange(len(cells)))
    if markers:
        raw.groups += _groups(nodes[:, 4 + attributes], 0, np.arange(len(nodes))[:, None])
    return raw


def _table(
    path: Path, width_of: Callable[[list[int]], int]
) -> tuple[NDArray[np.float64], list[int]]:
    """Rows of a file, and what its first line says after the number of rows (3 numbers)."""
    lines = [line.partition("#")[0] for line in read_text(path).splitlines()]
    section = Section(head="", lines=[line for line in lines if line.strip()], where=str(path))
    counts = section.integers(section.lines[:1]).tolist()
    counts += [0] * (4 - len(counts))  # a missing count of attributes or markers is 0
    width = width_of(counts)
    values = section.numbers(section.lines[1:])
    if counts[0] < 1 or min(counts) < 0 or len(values) != counts[0] * width:
        raise MeshError(
            f"{path} announces {counts[0]} rows of {width} numbers and holds {len(values)} "
            "numbers; the file is incomplete, save or copy it again"
        )
    return values.reshape(counts[0], width), counts[1:4]


def _in_vtk_order(points: NDArray[np.float64], cells: Integers, path: Path) -> Integers:
    """Sort the mid nodes by the edges they halve; TetGen's second-order cells are straight."""
    x = points[cells]
    halves = np.stack([0.5 * (x[:, a] + x[:, b]) for a, b in TET_EDGES], axis=1)
    misfit = np.array(
        [[np.abs(x[:, 4 + j] - halves[:, i]).sum() for j in range(6)] for i in range(6)]
    )
    columns = misfit.argmin(axis=1)
    if len(set(columns.tolist())) != 6:
        raise MeshError(f"{path}: the mid nodes do not halve the cells' edges; re-mesh with -o2")
    return cells[:, [*range(4), *(4 + columns)]]


def _groups(values: NDArray[np.float64], dimension: int, rows: Integers) -> list[RawGroup]:
    """One group for each whole-number value except 0."""
    found = np.unique(values[np.isfinite(values)])
    return [
        RawGroup(
            name=str(int(value)),
            number=int(value),
            dimension=dimension,
            parts=[rows[values == value]],
        )
        for value in found[(found != 0) & (found == np.trunc(found))]
    ]
