"""Symmetric tensors by their unique coefficients, and as matrices over pairs of coordinates.

Pairs i <= j stand in row-major order, (0, 0), (0, 1), ..., (1, 1), ...; unique coefficients
of order three and four in colexicographic order: that of i <= j <= k <= l stands at
i + C(j + 1, 2) + C(k + 2, 3) + C(l + 3, 4), with C the binomial coefficient. This place does not
depend on r, so that a tensor's beginning is the tensor of the first coordinates.
"""

from collections.abc import Iterable, Iterator
from math import comb, isqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_ASYMMETRY = 1e-8  # of the largest coefficient: round-off of tabulation is a thousandth of it


def pairs(r: int) -> tuple[Index, Index]:
    """Return i and j of all pairs i <= j < r, each (r (r + 1) / 2,)."""
    i, j = np.triu_indices(r)
    return i, j


def pair_places(r: int) -> Index:
    """Return the place of each pair in `pairs` as a symmetric matrix (r, r)."""
    i, j = pairs(r)
    places = np.empty((r, r), dtype=np.intp)
    places[i, j] = places[j, i] = np.arange(i.size)
    return places


def diagonal_weights(r: int) -> Array:
    """Return 1 for pairs i < j and 1/2 for i = j: sums over pairs equal half the sum over i, j."""
    i, j = pairs(r)
    return np.where(i == j, 0.5, 1.0)


def unique_count(r: int, order: int) -> int:
    """Return how many coefficients of a symmetric tensor of ``order`` indices are unique."""
    return comb(r + order - 1, order)


def unique_indices(r: int, order: int) -> Index:
    """Return the ascending indices of each unique coefficient (order, count) in their order."""
    found = np.arange(r, dtype=np.intp)[None, :]
    for rank in range(2, order + 1):
        # What stands before the last index is a beginning of the list one order lower.
        counts = [unique_count(last + 1, rank - 1) for last in range(r)]
        before = np.concatenate([found[:, :count] for count in counts], axis=1)
        found = np.vstack([before, np.repeat(np.arange(r), counts)])
    return found


def unique_third(matrix: Array) -> Array:
    """Return the unique coefficients of c_ijk given as ``matrix[(ij), k]`` (s, r).

    Raises:
        ValueError: the tensor is not symmetric to round-off.
    """
    return _mean(matrix[places] for places in _third_places(matrix.shape[1]))


def unique_fourth(matrix: Array) -> Array:
    """Return the unique coefficients of c_ijkl given as ``matrix[(ij), (kl)]`` (s, s).

    Raises:
        ValueError: the tensor is not symmetric to round-off.
    """
    splits = _fourth_places(_coordinates(matrix))
    return _mean(matrix[places] for ij, kl in splits for places in ((ij, kl), (kl, ij)))


def read_third(matrix: Array) -> Array:
    """Return what `unique_third` does of a matrix that is known to be exactly symmetric."""
    return matrix[next(_third_places(matrix.shape[1]))]


def read_fourth(matrix: Array) -> Array:
    """Return what `unique_fourth` does of a matrix that is known to be exactly symmetric."""
    return matrix[next(_fourth_places(_coordinates(matrix)))]


def _coordinates(matrix: Array) -> int:
    """Return r of a matrix with r (r + 1) / 2 rows."""
    return (isqrt(8 * len(matrix) + 1) - 1) // 2


def _third_places(r: int) -> Iterator[tuple[Index, Index]]:
    """Yield where each unique coefficient stands, for the three ways to split its indices."""
    place = pair_places(r)
    i, j, k = unique_indices(r, 3)
    yield place[i, j], k
    yield place[i, k], j
    yield place[j, k], i


def _fourth_places(r: int) -> Iterator[tuple[Index, Index]]:
    """Yield the same for two pairs."""
    place = pair_places(r)
    i, j, k, l = unique_indices(r, 4)  # noqa: E741
    yield place[i, j], place[k, l]
    yield place[i, k], place[j, l]
    yield place[i, l], place[j, k]


def _mean(equals: Iterable[Array]) -> Array:
    """Return the mean of arrays that differ by round-off; of equal ones, exactly them."""
    each = iter(equals)
    first = next(each)
    sum_of_shifts, count, apart = np.zeros_like(first), 1, 0.0
    for other in each:
        shift = other - first
        sum_of_shifts += shift
        count += 1
        apart = max(apart, np.abs(shift).max(initial=0.0))
    if not apart <= _ASYMMETRY * np.abs(first).max(initial=0.0):
        raise ValueError(
            f"coefficients that must be equal differ by {apart:.3g}: they are not derivatives of "
            "an energy"
        )
    return first + sum_of_shifts / count


def third_matrix(unique: Array, r: int) -> Array:
    """Return c_ijk as a matrix (s, r) over pairs (ij) and k, from its unique coefficients."""
    i, j = (index[:, None] for index in pairs(r))
    k = np.arange(r)
    low, high = np.minimum(i, k), np.maximum(j, k)
    middle = np.minimum(np.maximum(i, k), j)
    return unique[low + _choose(r, 2)[middle] + _choose(r, 3)[high]]


def fill_fourth_matrix(out: Array, unique: Array, r: int) -> None:
    """Write c_ijkl over pairs (ij) and (kl) to ``out`` (s, s), from its unique coefficients."""
    second, third, fourth = _choose(r, 2), _choose(r, 3), _choose(r, 4)
    k, l = pairs(r)  # noqa: E741
    begin = 0
    for i in range(r):  # one row of pairs at a time: the places of all would outweigh the matrix
        j = np.arange(i, r)[:, None]
        inner, outer = np.maximum(i, k), np.minimum(j, l)
        places = np.minimum(i, k) + second[np.minimum(inner, outer)]
        places += third[np.maximum(inner, outer)]
        places += fourth[np.maximum(j, l)]
        out[begin : begin + r - i] = unique[places]
        begin += r - i


def _choose(r: int, order: int) -> Index:
    """Return C(last + order - 1, order) for each last index < r."""
    return np.array([comb(last + order - 1, order) for last in range(r)], dtype=np.intp)
