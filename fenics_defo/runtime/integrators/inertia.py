"""Products with constant symmetric matrices, and the mass among them."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SolverError

Array = NDArray[np.float64]

#: Writes a product with a vector into a second array; both (r,), or (b, r).
type Product = Callable[[Array, Array], object]

# A mass that differs from the identity by no more than the round-off of a projection is it.
_IDENTITY = 1e-13
_ASYMMETRY = 1e-10  # of the largest entry: round-off of sums over a mesh stays far below


def product(matrix: Array, shape: tuple[int, ...]) -> Product:
    """A function that multiplies vectors of a shape by a symmetric matrix, fast if it is diagonal.

    Args:
        matrix: (r, r).
        shape: (r,), or (b, r) for b vectors at once.
    """
    diagonal = np.diagonal(matrix).copy()
    if not np.any(matrix - np.diag(diagonal)):
        return partial(np.multiply, diagonal)
    if len(shape) == 1:
        return partial(np.dot, np.ascontiguousarray(matrix))
    rows = np.ascontiguousarray(matrix)
    return lambda vectors, out: np.dot(vectors, rows, out)


class Inertia:
    """The mass matrix of a model.

    Args:
        matrix: M (r, r).
        shape: of the coordinates, (r,) or (b, r).

    Raises:
        SolverError: M is not symmetric and positive definite.
    """

    def __init__(self, matrix: Array, shape: tuple[int, ...]) -> None:
        size = shape[-1]
        self.matrix = np.array(matrix, dtype=np.float64)
        symmetric = self.matrix.shape == (size, size) and bool(
            np.abs(self.matrix - self.matrix.T).max() <= _ASYMMETRY * np.abs(self.matrix).max()
        )
        try:
            factor = np.linalg.cholesky(self.matrix) if symmetric else None
        except np.linalg.LinAlgError:
            factor = None
        if factor is None or not np.isfinite(factor).all():
            raise SolverError(
                f"the reduced mass must be a symmetric, positive definite matrix ({size}, {size}); "
                "this one is not: are two columns of the basis the same?"
            )
        #: L with M = L Lᵀ (r, r).
        self.factor: Array = factor
        #: Whether M is the identity.
        self.is_identity = bool(np.abs(self.matrix - np.eye(size)).max() <= _IDENTITY)
        if self.is_identity:
            self.matrix = np.eye(size)
        self.inverse: Array = np.eye(size) if self.is_identity else np.linalg.inv(self.matrix)
        #: M times, and M⁻¹ times; None where M is the identity.
        self.times = None if self.is_identity else product(self.matrix, shape)
        self.solve = None if self.is_identity else product(self.inverse, shape)

    def apply(self, vector: Array) -> Array:
        """M times a vector (..., r), as a new array."""
        return np.asarray(vector @ self.matrix)

    def acceleration(self, force: Array) -> Array:
        """M⁻¹ times a force (..., r), as a new array."""
        return np.asarray(force @ self.inverse)

    def squared_frequencies(self, stiffness: Array) -> Array:
        """Ascending ω² (..., r) [rad²/s²] of K φ = ω² M φ for K (..., r, r)."""
        left = np.linalg.solve(self.factor, stiffness)
        return np.linalg.eigvalsh(np.linalg.solve(self.factor, np.swapaxes(left, -1, -2)))
