"""Sections of .msh format 4.1."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.msh_cursor import MshCursor
from fenics_defo.fem.sources.msh_elements import ElementRun, element_type

Integers = NDArray[np.int64]
Entities = dict[tuple[int, int], tuple[int, ...]]


def read_entities(cursor: MshCursor, *, partitioned: bool) -> Entities:
    """Physical groups of each geometrical entity (dimension, tag)."""
    if partitioned:
        _, ghosts = cursor.sizes(2)
        cursor.integers(2 * int(ghosts))
    counts = cursor.sizes(4)
    entities: Entities = {}
    for dimension, count in enumerate(counts):
        for _ in range(int(count)):
            tag = int(cursor.integers(1)[0])
            if partitioned:
                cursor.integers(2)  # dimension and tag of the parent
                cursor.integers(_size(cursor))  # partitions
            cursor.doubles(3 if dimension == 0 else 6)  # the point, or the bounding box
            entities[dimension, tag] = tuple(cursor.integers(_size(cursor)).tolist())
            if dimension > 0:
                cursor.integers(_size(cursor))  # boundary entities
    return entities


def read_nodes(cursor: MshCursor) -> tuple[Integers, NDArray[np.float64]]:
    """Node numbers (n,) and coordinates (n, 3) in the file's order."""
    blocks, total = cursor.sizes(4)[:2]
    numbers, points = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))]
    for _ in range(int(blocks)):
        dimension, _, parametric = cursor.integers(3)
        count = _size(cursor)
        numbers.append(cursor.sizes(count))
        width = 3 + (int(dimension) if parametric else 0)
        points.append(cursor.doubles(width * count).reshape(count, width)[:, :3])
    result = np.concatenate(numbers), np.concatenate(points)
    _agree(cursor, "nodes", int(total), len(result[0]))
    return result


def read_elements(cursor: MshCursor, entities: Entities) -> list[ElementRun]:
    """Runs of elements of one type and entity, in the file's order."""
    blocks, total = cursor.sizes(4)[:2]
    runs = []
    for _ in range(int(blocks)):
        dimension, tag, kind = cursor.integers(3).tolist()
        count = _size(cursor)
        name, nodes = element_type(kind, cursor.what)
        rows = cursor.sizes(count * (1 + nodes)).reshape(count, 1 + nodes)
        runs.append(
            ElementRun(
                cell_type=name,
                numbers=rows[:, 0],
                nodes=rows[:, 1:],
                physicals=entities.get((dimension, tag), ()),
            )
        )
    _agree(cursor, "elements", int(total), sum(len(run.numbers) for run in runs))
    return runs


def _size(cursor: MshCursor) -> int:
    return int(cursor.sizes(1)[0])


def _agree(cursor: MshCursor, things: str, announced: int, found: int) -> None:
    if announced != found:
        raise MeshError(
            f"{cursor.what} announces {announced} {things} and holds {found}; "
            "save or copy the file again"
        )
