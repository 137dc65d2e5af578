"""What the integrators ask of a model."""

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Evaluator(Protocol):
    """Force and tangent in buffers of its own, which the next call overwrites."""

    def force(self, q: Array) -> Array:
        """f(q), of the shape of q."""

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """f(q), of the shape of q, and K(q) (..., r, r), symmetric."""


class MotionLaw(Protocol):
    """Reduced internal force of r coordinates."""

    kind: ClassVar[str]

    def evaluator(self, shape: tuple[int, ...]) -> Evaluator:
        """An evaluator for coordinates of a shape, (r,) or (b, r)."""


class MotionModel(Protocol):
    """M a + C v + f(q) = g in r coordinates."""

    @property
    def law(self) -> MotionLaw:
        """The internal force."""

    @property
    def size(self) -> int:
        """Number of coordinates r."""

    @property
    def mass(self) -> Array:
        """M (r, r), symmetric and positive definite."""

    @property
    def damping(self) -> tuple[float, float]:
        """Rayleigh's (alpha [1/s], beta [s])."""

    def energy(self, q: Array) -> Array:
        """Strain energy (...) [J] of q (..., r)."""
