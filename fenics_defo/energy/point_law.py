"""What a law is that no UFL expression gives: stress and tangent by NumPy at points."""

from collections.abc import Hashable, Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy.constants import Constant
from fenics_defo.runtime.laws import PointResponse

type Array = NDArray[np.float64]


@runtime_checkable
class PointLaw(Protocol):
    """A solid whose stress and tangent are computed by NumPy at the quadrature points.

    Each constant is a float, or a cell field (m,): one value a cell in the order of the mesh file.
    """

    @property
    def density(self) -> Constant:
        """Mass of the rest shape per volume ρ [kg/m³]."""

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """What `respond` needs, by name: Lamé's constants ``mu``, ``lmbda``, for example."""

    @property
    def formula(self) -> Hashable:
        """Equal for two laws whose `respond` is the same function of F and of `parameters`."""

    def respond(
        self,
        F: Array,
        parameters: Mapping[str, Array | float],
        *,
        tangent: bool = True,
        out: PointResponse | None = None,
    ) -> PointResponse:
        """Energy, stress and, if asked for, tangent at m points.

        Args:
            F: deformation gradients (m, 3, 3) [-].
            parameters: for each name of `parameters` a number, or (m,) one a point.
            tangent: whether the tangent is wanted.
            out: arrays of m points to write into, such as an earlier answer; its tangent must be
                there if it is wanted. Fresh arrays otherwise.

        Returns:
            ``out``, or a fresh response; NaN where F holds NaN.
        """

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of small strains about the rest shape."""
