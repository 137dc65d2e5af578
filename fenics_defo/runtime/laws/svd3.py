"""Singular value decomposition of batches of 3 × 3 matrices by two proper rotations."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import batches, components, cross, inner, product, transpose
from fenics_defo.runtime.laws.eigen3 import rotated, rotation, symmetric_eigen

type Array = NDArray[np.float64]

_TINY = 1e-300  # makes 0/0 zero, and is lost beside anything else
# Second stretch, relative to the first, that is nothing but round-off.
_ROUND_OFF = 4e-16


def signed_svd(F: Array) -> tuple[Array, Array, Array]:
    """F = U diag(s) Vᵀ with proper rotations U and V.

    Where det F < 0 it is the smallest stretch that is negative, so that a point is turned back
    along the shortest way (Irving, Teran and Fedkiw, Invertible finite elements for robust
    simulation of large deformation, 2004).

    Args:
        F: (m, 3, 3), of entries between 1e-150 and 1e150 in size, or zero.

    Returns:
        U (m, 3, 3), s (m, 3) with s1 ≥ s2 ≥ |s3|, and V (m, 3, 3): det U = det V = 1. The product
        is F to a few units of round-off of s1. NaN where F has NaN.
    """
    U, s, V = np.empty((len(F), 3, 3)), np.empty((len(F), 3)), np.empty((len(F), 3, 3))
    for part in batches(len(F)):
        left, stretches, right = svd_components(components(F[part]))
        U[part], s[part], V[part] = (
            left.transpose(2, 0, 1),
            stretches.T,
            right.transpose(2, 0, 1),
        )
    return U, s, V


def svd_components(F: Array) -> tuple[Array, Array, Array]:
    """`signed_svd` of one batch, components first: U (3, 3, b), s (3, b), V (3, 3, b).

    V are the eigenvectors of Fᵀ F. In the plane of the second and third their error is of the order
    ε s1²/(s2² − s3²); one rotation of these columns of F V mends it (Hestenes's one-sided Jacobi).
    """
    with np.errstate(invalid="ignore", over="ignore"):
        squares, V = symmetric_eigen(product(transpose(F), F))
        _exchange(squares, V, 0, 1)
        _exchange(squares, V, 0, 2)
        V[:, 1] = _straightened(F, V)
        V[:, 2] = cross(V[:, 0], V[:, 1])
        U, s = np.empty_like(V), np.empty_like(squares)
        images = product(F, V)
        s[0] = np.sqrt(inner(images[:, 0], images[:, 0]))
        U[:, 0] = images[:, 0] / (s[0] + _TINY)
        rest = images[:, 1] - inner(U[:, 0], images[:, 1]) * U[:, 0]
        s[1] = np.sqrt(inner(rest, rest))
        U[:, 1] = rest / (s[1] + _TINY)
        _complete(U, s)
        U[:, 2] = cross(U[:, 0], U[:, 1])
        s[2] = inner(U[:, 2], images[:, 2])
    return U, s, V


def _exchange(values: Array, vectors: Array, p: int, q: int) -> None:
    """Put the larger of the values p and q first, and its vector."""
    less = values[p] < values[q]
    for row in (values, *vectors):
        row[p], row[q] = np.where(less, row[q], row[p]), np.where(less, row[p], row[q])


def _straightened(F: Array, V: Array) -> Array:
    """V's second column turned in the plane of its third so that their images are orthogonal.

    Of the two directions that are, it is the one with the longer image.
    """
    a, b = (sum(F[:, i] * V[i, j] for i in range(3)) for j in (1, 2))
    first, second = inner(a, a), inner(b, b)
    cosine, sine, change = rotation(first, second, inner(a, b))
    u, v = rotated(V[:, 1], V[:, 2], cosine, sine)
    less = first - change < second + change
    return np.where(less, v, u)


def _complete(U: Array, s: Array) -> None:
    """Choose the vectors that a matrix of rank one or zero leaves open."""
    none = np.flatnonzero(s[0] == 0.0)
    U[:, 0, none] = np.array([[1.0], [0.0], [0.0]])
    some = np.flatnonzero(s[1] <= _ROUND_OFF * s[0])
    if some.size:
        axis = U[:, 0, some]
        other = np.zeros_like(axis)
        other[np.abs(axis).argmin(axis=0), np.arange(some.size)] = 1.0
        across = cross(axis, other)
        U[:, 1, some] = across / np.sqrt(inner(across, across))
