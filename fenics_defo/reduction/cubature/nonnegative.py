"""Non-negative least squares over columns that come and go one after the other."""

from copy import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SMALL = 1e-12  # of the largest weight: a weight as small is none
_DEPENDENT = 1e-6  # part of a column's square outside the others below which it adds nothing


class GrowingLeastSquares:
    """Minimises ‖Σ w_k c_k − b‖ over w ≥ 0 as columns c_k are added and removed.

    The active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23),
    begun at the last solution: a column that has been added enters with a positive weight, and
    those whose weights would turn negative leave for good.

    Args:
        target: b (rows,).
    """

    def __init__(self, target: Array) -> None:
        self._target = target
        self._size = float(np.linalg.norm(target))
        self._buffer = np.zeros((0, len(target)))
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

    @property
    def error(self) -> float:
        """Norm of `residual` over that of the target."""
        return float(np.linalg.norm(self.residual)) / self._size

    def gains(self, columns: Array) -> Array:
        """What each of some columns (k, rows) would take off the residual's norm squared (k,).

        That is (c·ρ)² / (‖c‖² − ‖P c‖²), with ρ the residual and P the projection on the columns in
        use: the step of orthogonal least squares (Chen, Billings and Luo, International Journal of
        Control 50, 1989). Zero for a column of which nothing positive would be added.
        """
        along = columns @ self.residual
        squares = np.vecdot(columns, columns)
        cross = self._columns @ columns.T
        outside = squares - np.vecdot(cross.T, _solution(self._gram, cross).T)
        outside = np.maximum(outside, _DEPENDENT * squares)
        gains: Array = np.divide(
            along**2, outside, out=np.zeros(len(along)), where=(along > 0.0) & (outside > 0.0)
        )
        return gains

    def add(self, keys: list[int], columns: Array) -> None:
        """Add columns (k, rows) under their keys, and solve again."""
        useful = np.vecdot(columns, columns) > 0.0
        columns = columns[useful]
        cross = self._columns @ columns.T
        own = columns @ columns.T
        self._gram = np.block([[self._gram, cross], [cross.T, own]])
        self._products = np.append(self._products, columns @ self._target)
        self._append(columns)
        self.keys = self.keys + [key for key, kept in zip(keys, useful, strict=True) if kept]
        self.weights = np.append(self.weights, np.zeros(len(columns)))
        self._solve()

    def without_cheapest(self) -> Self:
        """A copy without the column whose loss raises the residual least, solved again.

        Without column k the residual's norm squared grows by w_k² / (G⁻¹)_kk as long as the other
        weights stay positive, G being the products of the columns.
        """
        inverse = _solution(self._gram, np.eye(len(self.keys)))
        costs = self.weights**2 / np.diag(inverse)
        other = copy(self)
        other._keep(np.arange(len(costs)) != int(np.argmin(costs)), self.weights)
        other._solve()
        return other

    @property
    def _columns(self) -> Array:
        return self._buffer[: len(self.keys)]

    def _append(self, columns: Array) -> None:
        used = len(self.keys)
        needed = used + len(columns)
        if needed > len(self._buffer):
            grown = np.empty((max(needed, 2 * used), len(self._target)))
            grown[:used] = self._columns
            self._buffer = grown
        self._buffer[used:needed] = columns

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
        self._buffer = self._columns[chosen]  # a copy: others may still use the old one
        self.keys = [key for key, kept in zip(self.keys, chosen, strict=True) if kept]
        self._gram = self._gram[np.ix_(chosen, chosen)]
        self._products = self._products[chosen]
        self.weights = weights[chosen]


def _solution(gram: Array, right: Array) -> Array:
    """Gram⁻¹ times one or several right-hand sides, also where columns depend on each other."""
    if not len(gram):
        return np.zeros_like(right)
    scale = 1.0 / np.sqrt(np.diag(gram))
    scaled = gram * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += 1e-14
    across = scale if right.ndim == 1 else scale[:, None]
    solution: Array = across * np.linalg.solve(scaled, across * right)
    return solution
