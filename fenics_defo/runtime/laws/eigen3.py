"""Eigenvalues of batches of symmetric 3 × 3 matrices, by Jacobi's rotations."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import product, transpose

type Array = NDArray[np.float64]

_SWEEPS = 12  # five are the most that were ever seen to be needed
_EPSILON = np.finfo(np.float64).eps
_TINY = 1e-300  # makes 0/0 zero, and is lost beside anything else


def symmetric_eigen(A: Array) -> tuple[Array, Array]:
    """A = Q diag(a) Qᵀ by cyclic Jacobi rotations (Golub and Van Loan 2013, section 8.5).

    Args:
        A: (3, 3, b), symmetric; its upper half is read.

    Returns:
        a (3, b) in no order, and Q (3, 3, b), proper rotations.
    """
    diagonal = [A[0, 0].copy(), A[1, 1].copy(), A[2, 2].copy()]
    beside = {(0, 1): A[0, 1].copy(), (0, 2): A[0, 2].copy(), (1, 2): A[1, 2].copy()}
    count = A.shape[2]
    Q = [np.repeat(column[:, None], count, axis=1) for column in np.eye(3)]
    for _ in range(_SWEEPS):
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            pr, qr = (min(p, r), max(p, r)), (min(q, r), max(q, r))
            off = beside[p, q]
            c, s, change = rotation(diagonal[p], diagonal[q], off)
            diagonal[p] -= change
            diagonal[q] += change
            beside[p, q] = np.zeros(count)
            beside[pr], beside[qr] = rotated(beside[pr], beside[qr], c, s)
            Q[p], Q[q] = rotated(Q[p], Q[q], c, s)
        size = np.abs(diagonal[0]) + np.abs(diagonal[1]) + np.abs(diagonal[2])
        rest = np.abs(beside[0, 1]) + np.abs(beside[0, 2]) + np.abs(beside[1, 2])
        if not (rest > 0.25 * _EPSILON * size).any():  # NaN will not come nearer
            break
    return np.stack(diagonal), np.stack(Q, axis=1)


def rotation(first: Array, second: Array, off: Array) -> tuple[Array, Array, Array]:
    """Cosine and sine that annul ``off``, and what the second diagonal entry gains by it."""
    twice = off + off
    gap = second - first
    root = np.sqrt(gap * gap + twice * twice + _TINY)
    tangent = twice / (gap + np.copysign(root, gap))
    cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
    return cosine, tangent * cosine, tangent * off


def rotated(x: Array, y: Array, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Rows or columns x and y after the rotation of their plane: c x − s y and s x + c y."""
    new, term = cosine * x, sine * y
    new -= term
    other = cosine * y
    other += np.multiply(sine, x, out=term)
    return new, other


def raise_to_zero(A: Array) -> Array:
    """The symmetric matrices nearest to A (3, 3, b) that have no negative eigenvalue.

    A itself, bit for bit, where its leading minors show that it has none.
    """
    second = A[0, 0] * A[1, 1] - A[0, 1] * A[0, 1]
    third = (
        A[0, 0] * (A[1, 1] * A[2, 2] - A[1, 2] * A[1, 2])
        - A[0, 1] * (A[0, 1] * A[2, 2] - A[1, 2] * A[0, 2])
        + A[0, 2] * (A[0, 1] * A[1, 2] - A[1, 1] * A[0, 2])
    )
    some = np.flatnonzero(~((A[0, 0] > 0.0) & (second > 0.0) & (third > 0.0)))
    if some.size == 0:
        return A
    values, vectors = symmetric_eigen(A[:, :, some])
    result = A.copy()
    scaled = vectors * np.maximum(values, 0.0)
    result[:, :, some] = product(scaled, transpose(vectors))
    return result
