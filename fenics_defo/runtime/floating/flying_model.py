"""What a floating body needs of a reduced model."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.frame import FloatingFrame
from fenics_defo.runtime.forces.force_law import ForceLaw

Array = NDArray[np.float64]


class FlyingModel(Protocol):
    """What `FloatingBody` needs of a reduced model."""

    @property
    def law(self) -> ForceLaw:
        """Elastic force law of q."""

    @property
    def frame(self) -> FloatingFrame | None:
        """Integrals of mass; None for a body that is held."""

    @property
    def damping(self) -> tuple[float, float]:
        """(alpha [1/s], beta [s])."""

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Stored nodes (p,), zero-based in the file's order."""

    @property
    def points(self) -> Array:
        """Their places at rest (p, 3) [m]."""

    @property
    def shapes(self) -> Array:
        """Their displacements by the shapes (p, 3, r)."""
