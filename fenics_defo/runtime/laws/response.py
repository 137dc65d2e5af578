"""What a material answers at a batch of points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PointResponse:
    """Energy, stress and tangent at m points.

    Args:
        energy: strain energy per rest volume ψ (m,) [J/m³].
        stress: first Piola-Kirchhoff stress P = ∂ψ/∂F (m, 3, 3) [Pa].
        tangent: A_ijkl = ∂P_ij/∂F_kl (m, 3, 3, 3, 3) [Pa], contiguous; None where not asked for.
    """

    energy: Array
    stress: Array
    tangent: Array | None

    @classmethod
    def empty(cls, count: int, *, tangent: bool) -> "PointResponse":
        """Arrays for ``count`` points, not yet written."""
        return cls(
            energy=np.empty(count),
            stress=np.empty((count, 3, 3)),
            tangent=np.empty((count, 3, 3, 3, 3)) if tangent else None,
        )

    def part(self, points: slice) -> "PointResponse":
        """Views of some of the points: writing to them writes to this response."""
        tangent = None if self.tangent is None else self.tangent[points]
        return PointResponse(self.energy[points], self.stress[points], tangent)
