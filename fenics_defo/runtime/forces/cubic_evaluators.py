"""Evaluation of a cubic force with buffers of its own, for the loop over steps."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.forces.cubic_table import CubicTable

Array = NDArray[np.float64]


class CubicEvaluator:
    """Evaluator of one body; see `fenics_defo.runtime.forces.force_law.Evaluator`.

    For ten coordinates a call to NumPy costs as much as its arithmetic, so that there are few:
    two gathers of factors and their products ``[q / 3, 1, q, m]`` out of ``[q, 1, 1 / 3]``, one
    product with the table, one gather of K(q) and one product for f. Their buffers never change,
    so that the list of calls is made once.
    """

    __slots__ = ("_calls", "_coordinates", "_force", "_stiffness")

    def __init__(self, table: CubicTable) -> None:
        r = table.size
        every, one, third = np.arange(r), np.array([r]), np.array([r + 1])
        first = np.concatenate([every, one, every, table.first])
        second = np.concatenate([np.repeat(third, r), np.repeat(one, 1 + r), table.second])
        extended = np.empty(r + 2)
        extended[r:] = 1.0, 1.0 / 3.0
        left, right, products = np.empty((3, first.size))
        packed = np.empty(table.first.size)
        matrix = np.concatenate([np.zeros((r + 1, r)), table.rest])
        self._coordinates = extended[:r]
        self._stiffness = matrix[:r]
        self._force = np.empty(r)
        self._calls: tuple[tuple[Callable[..., object], tuple[object, ...]], ...] = (
            (extended.take, (first, None, left, "clip")),  # other modes gather to a copy of ``out``
            (extended.take, (second, None, right, "clip")),
            (np.multiply, (left, right, products)),
            (table.coefficients.dot, (products[r:], packed)),
            (packed.take, (table.places, None, self._stiffness, "clip")),
            (products.dot, (matrix, self._force)),
        )

    def force(self, q: Array) -> Array:
        """Return f (r,) at ``q`` (r,), overwritten by the next call."""
        return self.force_and_stiffness(q)[0]

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f (r,) and K (r, r), overwritten by the next call."""
        self._coordinates[:] = q
        for call, arguments in self._calls:
            call(*arguments)
        return self._force, self._stiffness


class CubicBatchEvaluator:
    """Evaluator of b bodies at once: matrix products instead of products with vectors.

    The products q_k q_l lie with the bodies along the last axis, where gathering them copies
    whole rows.
    """

    __slots__ = (
        "_bent",
        "_coordinates",
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

    def __init__(self, table: CubicTable, bodies: int) -> None:
        r, s = table.size, table.first.size
        self._table = table.coefficients.T
        self._matrix = table.rest
        self._first, self._second, self._places = table.first, table.second, table.places
        terms = np.empty((1 + r + s, bodies))
        terms[0] = 1.0
        self._terms = terms.T
        self._coordinates = terms[1 : 1 + r]
        self._products = terms[1 + r :]
        self._left = np.empty((s, bodies))
        self._packed = np.empty((bodies, s))
        self._stiffness = np.empty((bodies, r, r))
        self._force = np.empty((bodies, r))
        self._bent = np.empty((bodies, r, 1))

    def force(self, q: Array) -> Array:
        """Return f (b, r) at ``q`` (b, r), overwritten by the next call."""
        return self.force_and_stiffness(q)[0]

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f (b, r) and K (b, r, r), overwritten by the next call."""
        np.copyto(self._coordinates, q.T)
        self._coordinates.take(self._first, 0, self._left, "clip")
        self._coordinates.take(self._second, 0, self._products, "clip")
        np.multiply(self._left, self._products, self._products)
        np.dot(self._terms, self._table, self._packed)
        self._packed.take(self._places, 1, self._stiffness, "clip")
        np.dot(self._terms[:, 1:], self._matrix, self._force)
        np.matmul(self._stiffness, q[:, :, None], self._bent)
        np.multiply(self._bent, 1.0 / 3.0, self._bent)
        np.add(self._force, self._bent[:, :, 0], self._force)
        return self._force, self._stiffness
