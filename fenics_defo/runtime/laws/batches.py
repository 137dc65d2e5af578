"""Arithmetic of many 3 × 3 matrices at once, components first.

Inside the laws a batch of matrices is an array (3, 3, b): each component is one contiguous row,
and each operation of NumPy runs over a row. Batches are short enough to stay in a core's cache, and
where many matrices are made one after the other they are written into the same arrays: the C
library hands blocks of this size back to the system when they are freed, and to fetch them anew
costs as much as the arithmetic.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

# Points of one batch: a row is 16 kB. Shorter ones pay more for Python's calls, longer ones leave
# the second-level cache.
BATCH = 2048


def batches(count: int) -> Iterator[slice]:
    """Slices that cut ``count`` points into batches."""
    for start in range(0, count, BATCH):
        yield slice(start, min(start + BATCH, count))


def components(matrices: Array) -> Array:
    """(3, 3, b) of matrices (b, 3, 3)."""
    return np.ascontiguousarray(matrices.transpose(1, 2, 0))


def product(A: Array, B: Array) -> Array:
    """A B."""
    result, term = A[:, 0, None] * B[0], A[:, 1, None] * B[1]
    result += term
    result += np.multiply(A[:, 2, None], B[2], out=term)
    return result


def transpose(A: Array) -> Array:
    """Aᵀ, a view."""
    return A.transpose(1, 0, 2)


def inner(A: Array, B: Array) -> Array:
    """A : B (b,) of matrices, or the dot product of vectors (3, b)."""
    return (A * B).reshape(-1, A.shape[-1]).sum(axis=0)


def cofactor(A: Array) -> Array:
    """Cofactors of A: A⁻ᵀ det A where A is regular."""
    cyclic = np.empty((5, 5, A.shape[2]))
    cyclic[:3, :3] = A
    cyclic[3:, :3] = A[:2]
    cyclic[:, 3:] = cyclic[:, :2]
    result = cyclic[1:4, 1:4] * cyclic[2:5, 2:5]
    result -= cyclic[1:4, 2:5] * cyclic[2:5, 1:4]
    return result


def cross(a: Array, b: Array) -> Array:
    """Vector product a × b (3, b)."""
    result = np.empty_like(a)
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.subtract(a[j] * b[k], a[k] * b[j], out=result[i])
    return result


def rows(value: Array | float, part: slice) -> Array | float:
    """What a batch sees of a number, or of one number a point (m,)."""
    return value[part] if isinstance(value, np.ndarray) and value.ndim else value


def combined(matrices: Sequence[Array], weights: Sequence[Array], out: Array, term: Array) -> None:
    """Write Σ w A, of matrices (3, 3, b) with weights (b,), into ``out``; ``term`` is for use."""
    np.multiply(matrices[0], weights[0], out=out)
    for matrix, weight in zip(matrices[1:], weights[1:], strict=True):
        out += np.multiply(matrix, weight, out=term)


def store_block(out: Array, block: Array, i: int, k: int) -> None:
    """Write A_ijkl and its mirror A_klij from ``block``_jl (3, 3, b)."""
    for j in range(3):
        for m in range(3):
            out[:, i, j, k, m] = block[j, m]
            if i != k:
                out[:, k, m, i, j] = block[j, m]
