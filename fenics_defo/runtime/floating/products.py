"""Products of matrices and vectors with any leading axes; fastest without."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def times(matrix: Array, vector: Array) -> Array:
    """Matrices (..., m, n) times vectors (..., n)."""
    return matrix @ vector if vector.ndim == 1 else (matrix @ vector[..., None])[..., 0]


def by(vector: Array, rows: Array) -> Array:
    """Rows (..., 3, r) summed by the components of vectors (..., 3)."""
    if vector.ndim == 1:
        return vector @ rows
    return (vector[..., None, :] @ rows)[..., 0, :]


def transposed(matrix: Array) -> Array:
    """Matrices (..., n, m) of (..., m, n)."""
    return matrix.T if matrix.ndim == 2 else np.swapaxes(matrix, -1, -2)
