"""Forces that are cubic polynomials: exact for St. Venant-Kirchhoff, Taylor models of other laws.

With the symmetric third and fourth derivatives c_ijk and c_ijkl of the energy at rest,

    W = 1/2 K_ij q_i q_j + 1/6 c_ijk q_i q_j q_k + 1/24 c_ijkl q_i q_j q_k q_l

and its derivatives are f = (K + k2/2 + k3/3) q and K(q) = K + k2 + k3, where k2 = c_ijk q_k
and k3 = 1/2 c_ijkl q_k q_l. Barbic and James, ACM Transactions on Graphics 24(3), 2005, found
that the reduced force of this material is a cubic polynomial.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.forces.coordinates import by_batches, checked
from fenics_defo.runtime.forces.cubic_evaluators import CubicBatchEvaluator, CubicEvaluator
from fenics_defo.runtime.forces.cubic_table import CubicTable
from fenics_defo.runtime.forces.symmetric import (
    diagonal_weights,
    read_fourth,
    read_third,
    unique_count,
    unique_fourth,
    unique_third,
)
from fenics_defo.runtime.frozen import frozen_array, symmetric_array

Array = NDArray[np.float64]

_BUFFER = 1 << 20  # numbers in the largest buffer of a batch [8 MiB]


@dataclass(frozen=True, slots=True, eq=False)
class CubicForce:
    """Cubic force by its coefficients over pairs i <= j, s = r (r + 1) / 2 of them, row-major.

    The coefficients are made exactly symmetric under any exchange of indices: K is then the
    gradient of f to round-off, and a stored law comes back bit by bit.

    Args:
        linear: K_ij (r, r), the tangent at rest.
        quadratic: c_ijk (s, r) by pair (ij) and k.
        cubic: c_ijkl (s, s) by pairs (ij) and (kl), halved where k = l, so that
            k3 = cubic @ m with m = q_k q_l over pairs.

    Raises:
        ValueError: other shapes, values that are not finite, or coefficients without the
            symmetry of derivatives of an energy.
    """

    kind: ClassVar[str] = "cubic"
    ARRAYS: ClassVar[Mapping[str, ArraySpec]] = {
        "linear": ArraySpec("f", 2),
        "quadratic": ArraySpec("f", 1),
        "cubic": ArraySpec("f", 1),
    }

    linear: Array
    quadratic: Array
    cubic: Array
    _table: CubicTable = field(init=False, repr=False)

    def __post_init__(self) -> None:
        linear = symmetric_array("linear", self.linear)
        r = len(linear)
        s = unique_count(r, 2)
        quadratic = frozen_array("quadratic", self.quadratic, (s, r))
        cubic = frozen_array("cubic", self.cubic, (s, s)) / diagonal_weights(r)
        self._lay_out(linear, unique_third(quadratic), unique_fourth(cubic))

    @classmethod
    def from_unique(cls, linear: ArrayLike, third: ArrayLike, fourth: ArrayLike) -> Self:
        """Return the law with the given unique derivatives of the energy.

        Args:
            linear: K_ij (r, r).
            third: c_ijk for i <= j <= k, (r (r + 1) (r + 2) / 6,), at
                i + C(j + 1, 2) + C(k + 2, 3).
            fourth: c_ijkl for i <= j <= k <= l, (r (r + 1) (r + 2) (r + 3) / 24,), at
                i + C(j + 1, 2) + C(k + 2, 3) + C(l + 3, 4).

        Raises:
            ValueError: other shapes, or values that are not finite.
        """
        law = cls.__new__(cls)
        frozen = symmetric_array("linear", linear)
        r = len(frozen)
        quadratic = frozen_array("quadratic", third, (unique_count(r, 3),))
        law._lay_out(frozen, quadratic, frozen_array("cubic", fourth, (unique_count(r, 4),)))
        return law

    def _lay_out(self, linear: Array, third: Array, fourth: Array) -> None:
        """Keep one table; the public arrays are views of it."""
        table = CubicTable.from_unique(linear, third, fourth)
        parts = {"linear": linear, "quadratic": table.quadratic, "cubic": table.cubic}
        for name, value in (parts | {"_table": table}).items():
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.linear)

    def force(self, q: Array) -> Array:
        """Return f (..., r) at ``q`` (..., r)."""
        q = checked(q, self.size)
        if q.ndim == 1:
            return self._table.force_and_stiffness(q)[0]
        return by_batches(q, (self.size,), self._most, lambda b: self._both(b)[0])

    def stiffness(self, q: Array) -> Array:
        """Return K = df/dq (..., r, r), exactly symmetric, at ``q`` (..., r)."""
        q = checked(q, self.size)
        if q.ndim == 1:
            return self._table.force_and_stiffness(q)[1]
        return by_batches(q, (self.size, self.size), self._most, lambda b: self._both(b)[1])

    def energy(self, q: Array) -> Array:
        """Return W (...) [J] at ``q`` (..., r).

        Of f and K at q: W = q^T f / 2 - q^T (K(q) - K) q / 12.
        """
        q = checked(q, self.size)
        if q.ndim == 1:
            return self._energy(q, *self._table.force_and_stiffness(q))
        return by_batches(q, (), self._most, lambda b: self._energy(b, *self._both(b)))

    def _energy(self, q: Array, f: Array, k: Array) -> Array:
        bent = np.matmul(k - self.linear, q[..., None])[..., 0]
        return 0.5 * np.vecdot(q, f) - np.vecdot(q, bent) / 12.0

    def _both(self, q: Array) -> tuple[Array, Array]:
        """Return f (b, r) and K (b, r, r) of one batch."""
        return CubicBatchEvaluator(self._table, len(q)).force_and_stiffness(q)

    @property
    def _most(self) -> int:
        """Bodies of one batch."""
        return max(1, _BUFFER // self._table.first.size)

    def evaluator(self, shape: tuple[int, ...]) -> CubicEvaluator | CubicBatchEvaluator:
        """Return the law with buffers for coordinates of ``shape``, (r,) or (b, r)."""
        if len(shape) == 1:
            return CubicEvaluator(self._table)
        return CubicBatchEvaluator(self._table, shape[0])

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays that a model file holds: K and the unique coefficients."""
        return {
            "linear": self.linear,
            "quadratic": read_third(self.quadratic),
            "cubic": read_fourth(self.cubic / diagonal_weights(self.size)),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the law whose `arrays` these are, bit by bit.

        Raises:
            ValueError: they do not fit together.
        """
        return cls.from_unique(arrays["linear"], arrays["quadratic"], arrays["cubic"])


class TaylorForce(CubicForce):
    """Cubic Taylor polynomial at rest of another law: good near rest only.

    How near, a model says in its certificate.
    """

    __slots__ = ()

    kind: ClassVar[str] = "taylor"
