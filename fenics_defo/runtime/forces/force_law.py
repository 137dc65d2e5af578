"""What a reduced force law offers to models, integrators and model files."""

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.archive import ArraySpec

Array = NDArray[np.float64]


class Evaluator(Protocol):
    """A force law with buffers for coordinates of one shape, for the loop over steps.

    The arrays that its methods return belong to it: read them before the next call of any method,
    which overwrites them, and never write to them.
    """

    def force(self, q: Array) -> Array:
        """Return f (r,) or (b, r) at ``q`` of the evaluator's shape."""
        ...

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f as `force` does, and K = df/dq (r, r) or (b, r, r)."""
        ...


class ForceLaw(Protocol):
    """Internal force f(q) = dW/dq of r reduced coordinates.

    With mass-normalised shapes q is in kg^1/2 m, f in kg^1/2 m s^-2 and K in s^-2; with shapes
    without a unit they are in m, N and N/m.
    """

    kind: ClassVar[str]
    """Name of the law, the same in a model file."""

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        ...

    def force(self, q: Array) -> Array:
        """Return f (..., r) at ``q`` (..., r)."""
        ...

    def stiffness(self, q: Array) -> Array:
        """Return K = df/dq (..., r, r), symmetric, at ``q`` (..., r)."""
        ...

    def energy(self, q: Array) -> Array:
        """Return W (...) [J], 0 at q = 0, at ``q`` (..., r)."""
        ...

    def evaluator(self, shape: tuple[int, ...]) -> Evaluator:
        """Return the law with buffers for coordinates of ``shape``, (r,) or (b, r)."""
        ...


class StoredLaw(ForceLaw, Protocol):
    """A force law that a model file can hold."""

    ARRAYS: ClassVar[Mapping[str, ArraySpec]]
    """Name -> demand of what `arrays` returns."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays that a model file holds of this law."""
        ...

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the law whose `arrays` these are, bit by bit.

        Raises:
            ValueError: they do not fit together.
        """
        ...
