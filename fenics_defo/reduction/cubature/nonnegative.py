"""Non-negative least squares over columns that come one after the other."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SMALL = 1e-12  # of the largest weight: a weight as small is none


class GrowingLeastSquares:
    """Minimises ‖Σ w_k c_k − b‖ over w ≥ 0 as columns c_k are added.

    The active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23),
    begun at the last solution: a column that has been added enters with a positive weight, and
    those whose weights would turn negative leave for good.

    Args:
        target: b (rows,).
    """

    def __init__(self, target: Array) -> None:
        self._target = target
        self._columns = np.zeros((0, len(target)))
        self._gram = np.zeros((0, 0))
        self._products = np.zeros(0)
        #: Number that each column was added under, in the order of `weights`.
        self.keys: list[int] = []
        self.weights: Array = np.zeros(0)

    @property
    def residual(self) -> Array:
        """B − Σ w_k c_k (rows,)."""
        residual: Array = self._target - self.weights @ self._columns
        return residual

    def add(self, keys: list[int], columns: Array) -> None:
        """Add columns (k, rows) under their keys, and solve again."""
        scale = np.linalg.norm(columns, axis=1)
        columns = columns[scale > 0.0]
        self.keys += [key for key, size in zip(keys, scale, strict=True) if size > 0.0]
        cross = self._columns @ columns.T
        own = columns @ columns.T
        self._gram = np.block([[self._gram, cross], [cross.T, own]])
        self._products = np.append(self._products, columns @ self._target)
        self._columns = np.concatenate([self._columns, columns])
        self.weights = np.append(self.weights, np.zeros(len(columns)))
        self._solve()

    def _solve(self) -> None:
        while True:
            free = _solution(self._gram, self._products)
            if (free > 0.0).all():
                self.weights = free
                return
            # As far towards the free solution as no weight turns negative; what stops it leaves.
            falling = free <= 0.0
            gap = self.weights[falling] - free[falling]
            reach = np.where(gap > 0.0, self.weights[falling] / np.where(gap > 0.0, gap, 1.0), 0.0)
            step = float(reach.min())
            moved = self.weights + step * (free - self.weights)
            stopped = np.flatnonzero(falling)[reach <= step]
            moved[stopped] = 0.0
            self._keep(moved > _SMALL * max(float(moved.max()), np.finfo(float).tiny), moved)

    def _keep(self, chosen: NDArray[np.bool_], weights: Array) -> None:
        if chosen.all():  # round-off alone: the smallest leaves
            chosen = np.arange(len(weights)) != int(np.argmin(weights))
        self.keys = [key for key, kept in zip(self.keys, chosen, strict=True) if kept]
        self._columns = self._columns[chosen]
        self._gram = self._gram[np.ix_(chosen, chosen)]
        self._products = self._products[chosen]
        self.weights = weights[chosen]


def _solution(gram: Array, products: Array) -> Array:
    """Least-squares weights without bounds, also where columns depend on each other."""
    if not len(products):
        return products
    scale = 1.0 / np.sqrt(np.diag(gram))
    scaled = gram * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += 1e-14
    solution: Array = scale * np.linalg.solve(scaled, scale * products)
    return solution
