"""What the integrators ask of a model."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.forces.force_law import ForceLaw

Array = NDArray[np.float64]


class MotionModel(Protocol):
    """M a + C v + f(q) = g in r coordinates."""

    @property
    def law(self) -> ForceLaw:
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
