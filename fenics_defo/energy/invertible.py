"""Any isotropic law, continued through flat and inverted cells."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy.constants import Constant, within
from fenics_defo.energy.formula import formula
from fenics_defo.energy.material import IsotropicMaterial
from fenics_defo.energy.principal import StretchEnergy
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.laws import PointResponse, invertible

type Array = NDArray[np.float64]

#: Principal stretch below which a law is continued if nothing else is said.
THRESHOLD = 0.1

_Tangent = Literal["definite", "exact"]

# Energies made ready for evaluation, one for all materials of the same formula.
_COMPILED: dict[Hashable, StretchEnergy] = {}


@dataclass(frozen=True, slots=True)
class Invertible:
    """An isotropic law whose stress is continued linearly below a threshold of the stretches.

    Above the threshold it is the law itself, with whatever that lacks. St. Venant-Kirchhoff loses
    its stiffness in compression: along one axis its force has its limit at the stretch 1/√3, and
    at the threshold 0.1 it resists with a quarter of that. A threshold of 0.6 leaves its weak range
    out. Neo-Hookean and Mooney-Rivlin stiffen without bound towards 0: a threshold under 0.1 makes
    inverted cells stiffer than anything else and steps of Newton short. All of them have an
    indefinite tangent in compression, where thin shapes buckle; the definite one then keeps
    Newton's steps descents, and slows it down near the end.

    Below the threshold the stiffness across is a constant of the law, see
    `fenics_defo.runtime.laws.continuation.continued`.

    Args:
        material: any law with an energy of the invariants: StVenantKirchhoff, NeoHookean,
            MooneyRivlin or the user's IsotropicEnergy.
        threshold: principal stretch below which the law is continued, between 0 and 1 [-].
        tangent: "definite", the derivative of the stress with its negative eigenvalues at each
            point raised to zero; or "exact", as it is.

    Raises:
        MaterialError: ``material`` has no such energy, ``threshold`` is out of its range, or
            ``tangent`` is neither of the two.
    """

    material: IsotropicMaterial
    threshold: float = THRESHOLD
    tangent: _Tangent = "definite"
    _formula: Hashable = field(init=False, repr=False, compare=False)
    _energy: StretchEnergy = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.material, IsotropicMaterial):
            raise MaterialError(
                "an invertible law needs an energy of the principal stretches, which "
                f"{type(self.material).__name__} does not have; use StVenantKirchhoff, NeoHookean, "
                "MooneyRivlin or IsotropicEnergy (or Corotational, which stands inversion itself)"
            )
        object.__setattr__(self, "threshold", check_threshold(self.threshold))
        if self.tangent not in get_args(_Tangent):
            raise MaterialError(
                f'tangent must be "definite" or "exact", got {self.tangent!r}; '
                "leave it out for the definite one"
            )
        key = formula(self.material)
        if key not in _COMPILED:
            _COMPILED[key] = StretchEnergy.of(self.material)
        object.__setattr__(self, "_formula", key)
        object.__setattr__(self, "_energy", _COMPILED[key])

    @property
    def density(self) -> Constant:
        """Mass of the rest shape per volume ρ [kg/m³]."""
        return self.material.density

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """Those of the law."""
        return self.material.parameters

    @property
    def formula(self) -> Hashable:
        """Equal for laws of one energy function, one threshold and one kind of tangent."""
        return type(self), self.threshold, self.tangent, self._formula

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of small strains about the rest shape.

        Raises:
            MaterialError: those of the law's own.
        """
        return self.material.linearised()

    def respond(
        self,
        F: Array,
        parameters: Mapping[str, Array | float],
        *,
        tangent: bool = True,
        out: PointResponse | None = None,
    ) -> PointResponse:
        """Energy, stress and tangent at m points; see `PointLaw.respond`."""
        return invertible(
            F,
            self._energy,
            tuple(parameters[name] for name in self._energy.names),
            threshold=self.threshold,
            tangent=tangent,
            definite=self.tangent == "definite",
            out=out,
        )


def check_threshold(value: object) -> float:
    """``value`` as a threshold of the principal stretches.

    Raises:
        MaterialError: it is not a number between 0 and 1.
    """
    allowed = "be a number between 0 and 1 (0.1 is usual)"
    threshold = within("threshold", value, low=0.0, high=1.0, allowed=allowed)
    if not isinstance(threshold, float):
        raise MaterialError(f"threshold must {allowed}, got a field of {len(threshold)} values")
    return threshold
