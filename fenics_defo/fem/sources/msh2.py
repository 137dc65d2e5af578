"""Sections of .msh format 2 (2.0 to 2.2)."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.msh_cursor import MshCursor
from fenics_defo.fem.sources.msh_elements import ElementRun, element_type

Integers = NDArray[np.int64]


def read_nodes(cursor: MshCursor) -> tuple[Integers, NDArray[np.float64]]:
    """Node numbers (n,) and coordinates (n, 3) in the file's order."""
    count = _count(cursor)
    if cursor.binary:
        table = cursor.records([("number", "i4", (1,)), ("x", "f8", (3,))], count)
        return table["number"][:, 0].astype(np.int64), table["x"].astype(np.float64)
    rows = cursor.doubles(4 * count).reshape(count, 4)
    numbers = rows[:, 0].astype(np.int64)
    return numbers, np.ascontiguousarray(rows[:, 1:])


def read_elements(cursor: MshCursor) -> list[ElementRun]:
    """Runs of elements of one type, in the file's order."""
    left = _count(cursor)
    runs = []
    while left > 0:
        if cursor.binary:
            kind, count, tags = cursor.integers(3)
            name, nodes = element_type(int(kind), cursor.what)
            count = min(int(count), left)
            if count < 1 or tags < 0:
                raise MeshError(f"{cursor.what} is damaged: a block of {count} elements")
            rows = cursor.integers(count * (1 + tags + nodes)).reshape(count, -1)
            numbers, groups = rows[:, 0], rows[:, 1 : 1 + tags]
        else:
            rows, name, tags = _text_run(cursor, left)
            numbers, groups = rows[:, 0], rows[:, 3 : 3 + tags]
            nodes = rows.shape[1] - 3 - tags
        physicals = groups[:, 0] if tags else np.zeros(len(rows), dtype=np.int64)
        runs.append(
            ElementRun(cell_type=name, numbers=numbers, nodes=rows[:, -nodes:], physicals=physicals)
        )
        left -= len(rows)
    return runs


def _text_run(cursor: MshCursor, most: int) -> tuple[Integers, str, int]:
    """The longest run of rows (number, type, tag count, tags, nodes) that agree in type and tags.

    A row's length is known from its own type and tag count only. Chunks that double while all
    rows agree keep the number of steps small for long runs and the work small for short ones.
    """
    _, kind, tags = cursor.integers(3)
    cursor.position -= 3
    name, nodes = element_type(int(kind), cursor.what)
    width = int(3 + tags + nodes)
    if tags < 0 or cursor.rows_left(width) < 1:
        raise MeshError(f"{cursor.what} ends too early; save or copy the file again")
    chunks, length, chunk = [], 0, 16
    while length < most and (fit := min(chunk, most - length, cursor.rows_left(width))):
        rows = cursor.peek(fit, width)
        other = np.flatnonzero((rows[:, 1] != kind) | (rows[:, 2] != tags))
        same = int(other[0]) if len(other) else fit
        chunks.append(rows[:same])
        length += same
        cursor.position += same * width
        if same < fit:
            break
        chunk *= 2
    return np.concatenate(chunks), name, int(tags)


def _count(cursor: MshCursor) -> int:
    """The count that opens a section: a line of text even in binary files."""
    if not cursor.binary:
        return int(cursor.integers(1)[0])
    end = cursor.body.find(b"\n")
    try:
        count = int(cursor.body[:end])
    except ValueError:
        raise MeshError(f"{cursor.what} does not begin with a count; save it again") from None
    cursor.position = end + 1
    return count
