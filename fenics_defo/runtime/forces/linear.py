"""The force of linear elasticity: decoupled oscillators if the coordinates are vibration modes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.forces.coordinates import checked
from fenics_defo.runtime.frozen import symmetric_array

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LinearForce:
    """Force f = K q with a constant K, and the energy W = q^T K q / 2.

    Args:
        linear: K (r, r), symmetric, ``diag(omega^2)`` for mass-normalised modes.

    Raises:
        ValueError: a matrix that is not symmetric or not finite.
    """

    kind: ClassVar[str] = "linear"
    ARRAYS: ClassVar[Mapping[str, ArraySpec]] = {"stiffness": ArraySpec("f", 2)}

    linear: Array

    def __post_init__(self) -> None:
        frozen = symmetric_array("the stiffness", self.linear)
        object.__setattr__(self, "linear", frozen)

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.linear)

    def force(self, q: Array) -> Array:
        """Return f (..., r) at ``q`` (..., r)."""
        return checked(q, self.size) @ self.linear

    def stiffness(self, q: Array) -> Array:
        """Return K for each of ``q`` (..., r): (..., r, r)."""
        shape = checked(q, self.size).shape
        return np.broadcast_to(self.linear, (*shape, self.size)).copy()

    def energy(self, q: Array) -> Array:
        """Return W (...) [J] at ``q`` (..., r)."""
        q = checked(q, self.size)
        return 0.5 * np.vecdot(q, q @ self.linear)

    def evaluator(self, shape: tuple[int, ...]) -> "LinearEvaluator":
        """Return the law with buffers for coordinates of ``shape``, (r,) or (b, r)."""
        return LinearEvaluator(self.linear, shape)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays that a model file holds of this law."""
        return {"stiffness": self.linear}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the law whose `arrays` these are.

        Raises:
            ValueError: they do not fit together.
        """
        return cls(arrays["stiffness"])


class LinearEvaluator:
    """Evaluator of `LinearForce`; see `fenics_defo.runtime.forces.force_law.Evaluator`."""

    __slots__ = ("_force", "_matrix", "_stiffness")

    def __init__(self, matrix: Array, shape: tuple[int, ...]) -> None:
        self._matrix = matrix
        self._force = np.empty(shape)
        self._stiffness = np.broadcast_to(matrix, (*shape, len(matrix)))  # all bodies share one

    def force(self, q: Array) -> Array:
        """Return f at ``q``, overwritten by the next call."""
        return np.dot(q, self._matrix, self._force)

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f as `force` does, and the constant K, read-only."""
        return np.dot(q, self._matrix, self._force), self._stiffness
