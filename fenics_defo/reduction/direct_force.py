"""The unreduced Galerkin force, which every cheaper one is measured against."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection

Array = NDArray[np.float64]


class DirectForce:
    """f(q) = Uᵀ f(U q), assembled over the whole body at each call; any law, any element.

    It needs FEniCSx and costs what a step of the full simulation costs but for the solution, so it
    is a reference and cannot be stored. Its methods are collective on ``solid.comm``: call them
    with the same q on each rank.

    Args:
        solid: body.
        shapes: U (r, n, 3), nodes in the order of the user's file.

    Raises:
        DefoError: shapes that are not the body's, or not finite.
    """

    kind: ClassVar[str] = "direct"
    ARRAYS: ClassVar[Mapping[str, Any]] = {}

    def __init__(self, solid: Solid, shapes: ArrayLike) -> None:
        self._projection = Projection(solid, shapes)

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return self._projection.size

    def force(self, q: ArrayLike) -> Array:
        """Return f (..., r) at ``q`` (..., r)."""
        return self._each(q, (self.size,), self._projection.force)

    def stiffness(self, q: ArrayLike) -> Array:
        """Return K = df/dq (..., r, r), symmetric, at ``q`` (..., r)."""
        tail = (self.size, self.size)
        return self._each(q, tail, lambda one: self._projection.force_and_stiffness(one)[1])

    def energy(self, q: ArrayLike) -> Array:
        """Return the strain energy (...) [J] at ``q`` (..., r)."""
        return self._each(q, (), self._projection.energy)

    def evaluator(self, shape: tuple[int, ...]) -> "DirectEvaluator":
        """Return the law for coordinates of ``shape``, (r,) or (b, r)."""
        if not (1 <= len(shape) <= 2 and shape[-1] == self.size):
            raise ValueError(f"the shape must be ({self.size},) or (b, {self.size}), got {shape}")
        return DirectEvaluator(self._projection, shape)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Raise, for there is nothing smaller than the body to store.

        Raises:
            DefoError: always.
        """
        raise DefoError(
            'a model with the force "direct" assembles the whole body and cannot be stored; reduce '
            'with force = "cubic" or "taylor" to store it'
        )

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Raise, for no file holds such a law.

        Raises:
            ValueError: always.
        """
        raise ValueError("the direct force is not stored")

    def _each(
        self, q: ArrayLike, tail: tuple[int, ...], evaluate: Callable[[Array], Array | float]
    ) -> Array:
        points = np.asarray(q, dtype=np.float64)
        if points.ndim == 0 or points.shape[-1] != self.size:
            raise ValueError(f"q must have the shape (..., {self.size}), got {points.shape}")
        answer = np.empty((*points.shape[:-1], *tail))
        for place in np.ndindex(points.shape[:-1]):
            answer[place] = evaluate(points[place])
        return answer


class DirectEvaluator:
    """Evaluator of `DirectForce`; see `fenics_defo.runtime.forces.force_law.Evaluator`."""

    def __init__(self, projection: Projection, shape: tuple[int, ...]) -> None:
        self._projection = projection
        self._force = np.empty(shape)
        self._stiffness = np.empty((*shape, shape[-1]))

    def force(self, q: Array) -> Array:
        """Return f at ``q``, overwritten by the next call."""
        for place in np.ndindex(self._force.shape[:-1]):
            self._force[place] = self._projection.force(q[place])
        return self._force

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f as `force` does, and K, overwritten by the next call."""
        for place in np.ndindex(self._force.shape[:-1]):
            force, stiffness = self._projection.force_and_stiffness(q[place])
            self._force[place], self._stiffness[place] = force, stiffness
        return self._force, self._stiffness
