"""The equations of a step about an iterate, and their solution."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

    def solved(self) -> tuple[Array, Array]:
        """Changes of q (..., r) and of the spin (..., 3).

        By elimination of q, whose equations have units of their own, and three equations left.
        """
        right = np.concatenate([self.shape[..., None], self.shape_by_spin], axis=-1)
        answer = np.linalg.solve(self.shape_by_q, right)
        alone, along = answer[..., :1], answer[..., 1:]
        reduced = self.spin_by_spin - self.spin_by_q @ along
        turn = np.linalg.solve(reduced, self.spin_by_q @ alone - self.spin[..., None])
        return -(alone + along @ turn)[..., 0], turn[..., 0]


def _excess(residual: Array, terms: tuple[Array, ...]) -> float:
    """Largest norm of a residual (..., k) relative to the largest of its terms."""
    size = np.sqrt((residual * residual).sum(axis=-1))
    scale = np.sqrt(np.max([(term * term).sum(axis=-1) for term in np.broadcast_arrays(*terms)], 0))
    ratio = np.divide(size, scale, out=np.array(size), where=scale > 0.0)
    return float(np.max(ratio))
