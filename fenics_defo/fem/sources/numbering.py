"""From the numbers that files use to rows of arrays, without loops."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError

Integers = NDArray[np.int64]


def rows_of(wanted: Integers, numbers: Integers, *, what: str, thing: str) -> Integers:
    """Rows at which ``wanted`` numbers stand in ``numbers``, of the shape of ``wanted``.

    Args:
        wanted: numbers that the file refers to, any shape.
        numbers: (n,) numbers that the file defines.
        what: path and section, to begin a sentence with.
        thing: "node" or "cell".

    Raises:
        MeshError: a number is defined twice, or referred to and not defined.
    """
    if len(numbers) == 0 and wanted.size:
        raise MeshError(f"{what} refers to {thing}s, but the file defines none; save it again")
    order = np.argsort(numbers, kind="stable")
    ordered = numbers[order]
    twice = ordered[1:][np.diff(ordered) == 0]
    if len(twice):
        raise MeshError(
            f"{what}: the file defines {thing} {twice[0]} more than once ({len(twice)} such "
            "numbers); renumber the mesh"
        )
    if wanted.size == 0:
        return np.zeros(wanted.shape, dtype=np.int64)
    place = np.minimum(np.searchsorted(ordered, wanted), len(ordered) - 1)
    lost = ordered[place] != wanted
    if np.any(lost):
        raise MeshError(
            f"{what} refers to {thing} {wanted[lost].flat[0]}, which the file does not define "
            f"(it defines {len(numbers)} {thing}s, {ordered[0]} to {ordered[-1]}; "
            f"{np.count_nonzero(lost)} such references); mend or save the file again"
        )
    return order[place].astype(np.int64)


def row_keys(*tables: Integers) -> list[Integers]:
    """One integer for each row of the tables, equal exactly where rows hold the same numbers.

    The order within a row does not count. Tables have the same number of columns.
    """
    rows = np.sort(np.concatenate(tables), axis=1)
    keys = rows[:, 0] if rows.shape[1] else np.zeros(len(rows), dtype=np.int64)
    for column in rows.T[1:]:
        # Compressed to 0..k at each step, so that the product cannot overflow.
        keys = np.unique(keys, return_inverse=True)[1] * (rows.max(initial=0) + 1) + column
    return np.split(keys, np.cumsum([len(table) for table in tables])[:-1])
