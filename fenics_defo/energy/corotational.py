"""Corotational linear elasticity: Hooke's law in a frame that turns with the deformation."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy.two_moduli import TwoModuli
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.laws import PointResponse, corotational

type Array = NDArray[np.float64]

_Tangent = Literal["exact", "definite", "approximate"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corotational(TwoModuli):
    """Corotational elasticity: ψ = μ |F − R|² + λ/2 tr(Rᵀ F − I)², R the rotation nearest to F.

    For large rotations and small to moderate strains; finite also for crushed and inverted cells,
    which it turns back.

    Args:
        young: Young's modulus E [Pa], positive.
        poisson: Poisson's ratio ν [-], strictly between -1 and 0.5.
        density: mass of the rest shape per volume ρ [kg/m³], positive.
        tangent: "exact", the derivative of the stress, R's change included; "definite", the same
            with its negative eigenvalues at each point raised to zero; "approximate", the
            classical warped stiffness: Hooke's tensor turned by R.

    Raises:
        MaterialError: a constant is out of its range, fields have different lengths, or
            ``tangent`` is none of the three.
    """

    tangent: _Tangent = "exact"

    def __post_init__(self) -> None:
        TwoModuli.__post_init__(self)
        if self.tangent not in get_args(_Tangent):
            raise MaterialError(
                'tangent must be "exact", "definite" or "approximate", '
                f"got {self.tangent!r}; leave it out for the exact one"
            )

    @property
    def formula(self) -> Hashable:
        """Equal for two corotational laws of one kind of tangent."""
        return type(self), self.tangent

    def respond(
        self,
        F: Array,
        parameters: Mapping[str, Array | float],
        *,
        tangent: bool = True,
        out: PointResponse | None = None,
    ) -> PointResponse:
        """Energy, stress and tangent at m points; see `PointLaw.respond`."""
        return corotational(
            F,
            parameters["mu"],
            parameters["lmbda"],
            tangent=self.tangent if tangent else None,
            out=out,
        )
