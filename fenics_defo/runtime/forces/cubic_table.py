"""The coefficients of a cubic force, laid out so that one product gives the tangent.

From K(q) = K + k2 + k3 follows f = (K + k2/2 + k3/3) q = (K(q) q + 2 K q + k2 q / 2) / 3, and
k2 q / 2 is a product of the quadratic coefficients with the same products m = q_k q_l. No matrix
but K(q) need be unpacked from pairs, and the table is read once, which is what takes the time.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.forces.symmetric import (
    diagonal_weights,
    fill_fourth_matrix,
    pair_places,
    pairs,
    third_matrix,
)

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class CubicTable:
    """What evaluating a cubic force of r coordinates reads, s = r (r + 1) / 2.

    Args:
        coefficients: [K over pairs, quadratic, cubic] (s, 1 + r + s); times [1, q, m] it is K(q)
            over pairs.
        rest: (r + s, r); [q, m] times it is (2 K q + k2 q / 2) / 3.
        first: k of each pair (s,).
        second: l of each pair (s,).
        places: pair of each entry of a symmetric matrix (r, r).
    """

    coefficients: Array
    rest: Array
    first: Index
    second: Index
    places: Index

    @classmethod
    def from_unique(cls, linear: Array, third: Array, fourth: Array) -> Self:
        """Lay out K (r, r) and the unique third and fourth derivatives of the energy."""
        r = len(linear)
        first, second = pairs(r)
        weights = diagonal_weights(r)
        s = weights.size
        table = np.empty((s, 1 + r + s))
        table[:, 0] = linear[first, second]
        table[:, 1 : 1 + r] = third_matrix(_without_tiny(third), r)
        fill_fourth_matrix(table[:, 1 + r :], _without_tiny(fourth), r)
        table[:, 1 + r :] *= weights
        table.flags.writeable = False
        rest = np.concatenate([linear * 2.0, table[:, 1 : 1 + r] * weights[:, None]]) / 3.0
        return cls(table, rest, first, second, pair_places(r))

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.places)

    @property
    def quadratic(self) -> Array:
        """c_ijk by pair (ij) and k (s, r)."""
        return self.coefficients[:, 1 : 1 + self.size]

    @property
    def cubic(self) -> Array:
        """c_ijkl by pairs (ij) and (kl), halved where k = l (s, s)."""
        return self.coefficients[:, 1 + self.size :]

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return new arrays f (r,) and K (r, r) at ``q`` (r,)."""
        terms = np.concatenate([_ONE, q, q[self.first] * q[self.second]])
        stiffness = np.dot(self.coefficients, terms)[self.places]
        return np.dot(stiffness, q) / 3.0 + np.dot(terms[1:], self.rest), stiffness


_ONE = np.ones(1)


def _without_tiny(coefficients: Array) -> Array:
    """Return them with 0 for what is too small to be halved and doubled again exactly."""
    return np.where(np.abs(coefficients) < 4.0 * np.finfo(float).tiny, 0.0, coefficients)
