"""Singular value decomposition of batches of 3 × 3 matrices by two proper rotations."""

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


def signed_svd(F: Array) -> tuple[Array, Array, Array]:
    """F = U diag(s) Vᵀ with proper rotations U and V.

    Args:
        F: (m, 3, 3).

    Returns:
        U (m, 3, 3), s (m, 3) with s1 ≥ s2 ≥ |s3|, and V (m, 3, 3): det U = det V = 1.
    """
    U, s, Vt = np.linalg.svd(F)
    left, right = np.linalg.det(U), np.linalg.det(Vt)
    U[:, :, 2] *= left[:, None]
    Vt[:, 2] *= right[:, None]
    s[:, 2] *= left * right
    return U, s, Vt.transpose(0, 2, 1)
