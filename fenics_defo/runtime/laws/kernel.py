"""What a force law asks of a material at its points."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

#: Entry 3 i + j of a stress or gradient is its component ij.
IDENTITY = np.eye(3).reshape(9)


class PointKernel(Protocol):
    """One law at n points, with buffers made once; answers are overwritten by the next call."""

    #: (9, n) deformation gradients F, component 3 i + j first: written by the caller.
    gradients: Array

    def energy(self) -> Array:
        """Strain energies per rest volume ψ (n,) [J/m³] at `gradients`."""

    def stress(self) -> Array:
        """First Piola-Kirchhoff stresses P (9, n) [Pa] at `gradients`."""

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa] at `gradients`."""
