"""Evaluation of a cubic force: one product with the table gives the tangent.

From K(q) = K + k2 + k3 follows f = (K + k2/2 + k3/3) q = (K(q) q + 2 K q + k2 q / 2) / 3, and
k2 q / 2 is a product of the quadratic coefficients with the same products m = q_k q_l. No matrix
but K(q) need be unpacked from pairs, and the table is read once, which is what takes the time.
"""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.forces.symmetric import diagonal_weights, pair_places, pairs

Array = NDArray[np.float64]


def _rest(table: Array, linear: Array) -> Array:
    """Return the matrix (r + s, r) that takes [q, m] to (2 K q + k2 q / 2) / 3."""
    r = len(linear)
    halved = table[:, 1 : 1 + r] * diagonal_weights(r)[:, None]
    return np.concatenate([linear * (2.0 / 3.0), halved / 3.0])


class CubicEvaluator:
    """Evaluator of one body; see `fenics_defo.runtime.forces.force_law.Evaluator`.

    For ten coordinates a call to NumPy costs as much as its arithmetic, so that there are few:
    one gather of all products ``[q / 3, 1, q, m]`` from ``[q, 1, 1 / 3]`` by two lists of places,
    one product with the table, one gather of K(q) and one product for f.
    """

    __slots__ = (
        "_coordinates",
        "_extended",
        "_first",
        "_force",
        "_left",
        "_matrix",
        "_packed",
        "_places",
        "_products",
        "_right",
        "_second",
        "_stiffness",
        "_table",
        "_terms",
    )

    def __init__(self, table: Array, linear: Array) -> None:
        r = len(linear)
        i, j = pairs(r)
        every, one, third = np.arange(r), np.array([r]), np.array([r + 1])
        self._table = table
        self._extended = np.empty(r + 2)
        self._extended[r:] = 1.0, 1.0 / 3.0
        self._coordinates = self._extended[:r]
        self._first = np.concatenate([every, one, every, i])
        self._second = np.concatenate([np.repeat(third, r), np.repeat(one, 1 + r), j])
        self._left, self._right, self._products = np.empty((3, self._first.size))
        self._terms = self._products[r:]
        self._packed = np.empty(len(table))
        self._places = pair_places(r)
        self._matrix = np.concatenate([linear, np.zeros((1, r)), _rest(table, linear)])
        self._stiffness = self._matrix[:r]
        self._force = np.empty(r)

    def force(self, q: Array) -> Array:
        """Return f (r,) at ``q`` (r,), overwritten by the next call."""
        return self.force_and_stiffness(q)[0]

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f (r,) and K (r, r), overwritten by the next call."""
        np.copyto(self._coordinates, q)
        self._extended.take(self._first, None, self._left, "clip")
        self._extended.take(self._second, None, self._right, "clip")
        np.multiply(self._left, self._right, self._products)
        np.dot(self._table, self._terms, self._packed)
        self._packed.take(self._places, None, self._stiffness, "clip")
        return np.dot(self._products, self._matrix, self._force), self._stiffness


class CubicBatchEvaluator:
    """Evaluator of b bodies at once: matrix products instead of products with vectors.

    The products q_k q_l lie with the bodies along the last axis, where gathering them copies
    whole rows.
    """

    __slots__ = (
        "_first",
        "_force",
        "_left",
        "_matrix",
        "_packed",
        "_places",
        "_products",
        "_second",
        "_stiffness",
        "_table",
        "_terms",
    )

    def __init__(self, table: Array, linear: Array, bodies: int) -> None:
        r = len(linear)
        self._table = table
        self._first, self._second = pairs(r)
        self._terms = np.empty((table.shape[1], bodies))
        self._terms[0] = 1.0
        self._products = self._terms[1 + r :]
        self._left = np.empty((len(table), bodies))
        self._packed = np.empty((bodies, len(table)))
        self._places = pair_places(r)
        self._stiffness = np.empty((bodies, r, r))
        self._force = np.empty((bodies, r))
        self._matrix = _rest(table, linear)

    def force(self, q: Array) -> Array:
        """Return f (b, r) at ``q`` (b, r), overwritten by the next call."""
        return self.force_and_stiffness(q)[0]

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f (b, r) and K (b, r, r), overwritten by the next call."""
        r = self._force.shape[1]
        coordinates = self._terms[1 : 1 + r]
        np.copyto(coordinates, q.T)
        coordinates.take(self._first, 0, self._left, "clip")
        coordinates.take(self._second, 0, self._products, "clip")
        np.multiply(self._left, self._products, self._products)
        np.dot(self._terms.T, self._table.T, self._packed)
        self._packed.take(self._places, 1, self._stiffness, "clip")
        np.dot(self._terms[1:].T, self._matrix, self._force)
        self._force += np.matmul(self._stiffness, q[:, :, None])[:, :, 0] / 3.0
        return self._force, self._stiffness
