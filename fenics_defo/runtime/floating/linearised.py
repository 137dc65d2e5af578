"""The equations of a step about an iterate, and their solution."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.dense_solver import solve

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LinearisedStep:
    """The equations of the end of a step about an iterate: residuals and their derivatives.

    Args:
        shape: residual of q (..., r).
        spin: residual of the angular momentum (..., 3).
        shape_by_q: (..., r, r).
        shape_by_spin: (..., r, 3).
        spin_by_q: (..., 3, r).
        spin_by_spin: (..., 3, 3).
        terms: what the two residuals are sums of.
    """

    shape: Array
    spin: Array
    shape_by_q: Array
    shape_by_spin: Array
    spin_by_q: Array
    spin_by_spin: Array
    terms: tuple[tuple[Array, ...], tuple[Array, ...]]

    def excess(self) -> float:
        """Largest residual relative to the largest term [-]."""
        return max(_excess(self.shape, self.terms[0]), _excess(self.spin, self.terms[1]))

    def solved(self, scale: float) -> tuple[Array, Array]:
        """Changes of q (..., r) and of the spin (..., 3).

        Args:
            scale: unit of the spin's equations in that of the equations of q.
        """
        r = self.shape.shape[-1]
        matrix = np.empty((*self.shape.shape[:-1], r + 3, r + 3))
        matrix[..., :r, :r] = self.shape_by_q
        np.multiply(self.shape_by_spin, scale, out=matrix[..., :r, r:])
        np.multiply(self.spin_by_q, scale, out=matrix[..., r:, :r])
        np.multiply(self.spin_by_spin, scale * scale, out=matrix[..., r:, r:])
        right, answer = np.empty((2, *matrix.shape[:-1]))
        right[..., :r] = self.shape
        np.multiply(self.spin, scale, out=right[..., r:])
        solve(matrix, right, answer)
        return -answer[..., :r], -scale * answer[..., r:]


def _excess(residual: Array, terms: tuple[Array, ...]) -> float:
    """Largest norm of a residual (..., k) relative to the largest of its terms."""
    size = np.sqrt((residual * residual).sum(axis=-1))
    scale = np.sqrt(np.max([(term * term).sum(axis=-1) for term in np.broadcast_arrays(*terms)], 0))
    ratio = np.divide(size, scale, out=np.array(size), where=scale > 0.0)
    return float(np.max(ratio))
