"""Products of matrices and vectors with any leading axes."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def times(matrix: Array, vector: Array) -> Array:
    """Matrices (..., m, n) times vectors (..., n)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])


def by(vector: Array, rows: Array) -> Array:
    """Rows (..., 3, r) summed by the components of vectors (..., 3)."""
    return np.asarray((vector[..., None, :] @ rows)[..., 0, :])
