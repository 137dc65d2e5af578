"""The material laws of the package, as validated records of their constants.

ψ is the strain energy per rest volume [J/m³]. Sources: Bonet and Wood, Nonlinear Continuum
Mechanics for Finite Element Analysis (2008), section 6.4 (St. Venant-Kirchhoff, neo-Hookean);
Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5 (Mooney-Rivlin).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import ufl
from ufl.core.expr import Expr

from fenics_defo.energy.constants import (
    Constant,
    equal_by_value,
    finite,
    hash_by_value,
    positive,
    store,
)
from fenics_defo.energy.kinematics import green_lagrange, invariants, isochoric, small_strain
from fenics_defo.energy.two_moduli import TwoModuli


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearElastic(TwoModuli):
    """Linear elasticity: ψ = λ/2 (tr ε)² + μ ε:ε with ε = sym(F) − I.

    Not objective: a rigid rotation by θ stores energy of order θ⁴, so it has no energy of the
    invariants. Meant for small strains and small rotations.

    Args:
        young: Young's modulus E [Pa], positive.
        poisson: Poisson's ratio ν [-], strictly between -1 and 0.5.
        density: mass of the rest shape per volume ρ [kg/m³], positive.
    """

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar."""
        return _quadratic(small_strain(F), parameters)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StVenantKirchhoff(TwoModuli):
    """St. Venant-Kirchhoff: ψ = λ/2 (tr E)² + μ E:E with E = (Fᵀ F − I)/2.

    For large rotations and small strains. In uniaxial compression the force has its limit at the
    stretch 1/√3 and falls beyond: no law for strong compression.

    Args:
        young: Young's modulus E [Pa], positive.
        poisson: Poisson's ratio ν [-], strictly between -1 and 0.5.
        density: mass of the rest shape per volume ρ [kg/m³], positive.
    """

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar, of fourth degree in F."""
        return _quadratic(green_lagrange(F), parameters)

    def invariant_energy(self, I1: Expr, I2: Expr, J: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """ψ = λ/8 (I1 − 3)² + μ/4 (I1² − 2 I2 − 2 I1 + 3), because tr C² = I1² − 2 I2."""
        return parameters["lmbda"] / 8 * (I1 - 3) ** 2 + parameters["mu"] / 4 * (
            I1**2 - 2 * I2 - 2 * I1 + 3
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NeoHookean(TwoModuli):
    """Compressible neo-Hookean: ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)².

    For large strains; ψ grows without bound as J falls to 0, and is undefined (NaN) below.

    Args:
        young: Young's modulus E [Pa], positive.
        poisson: Poisson's ratio ν [-], strictly between -1 and 0.5.
        density: mass of the rest shape per volume ρ [kg/m³], positive.
    """

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar."""
        return self.invariant_energy(*invariants(F), parameters)

    def invariant_energy(self, I1: Expr, I2: Expr, J: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(I1, I2, J) [J/m³], equal to `strain_energy`."""
        mu, lmbda, log = parameters["mu"], parameters["lmbda"], ufl.ln(J)
        return mu / 2 * (I1 - 3) - mu * log + lmbda / 2 * log**2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MooneyRivlin:
    """Mooney-Rivlin: ψ = c10 (J^(−2/3) I1 − 3) + c01 (J^(−4/3) I2 − 3) + bulk/2 (J − 1)².

    For rubber. Each constant is a number, or (m,) numbers, one a cell.

    Args:
        c10: weight of the first modified invariant [Pa].
        c01: weight of the second [Pa]; fits of measurements give negative ones too, so that only
            c10 + c01, half of the shear modulus, must be positive.
        bulk: bulk modulus [Pa], positive.
        density: mass of the rest shape per volume ρ [kg/m³], positive.

    Raises:
        MaterialError: a constant is out of its range, or fields have different lengths.
    """

    c10: Constant
    c01: Constant
    bulk: Constant
    density: Constant

    def __post_init__(self) -> None:
        constants = {
            "c10": finite("c10", self.c10),
            "c01": finite("c01", self.c01),
            "bulk": positive("bulk", self.bulk, unit="Pa"),
            "density": positive("density", self.density, unit="kg/m³"),
        }
        store(self, constants)
        positive("c10 + c01", self.c10 + self.c01, unit="Pa")

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """The constants ``c10``, ``c01`` and ``bulk`` [Pa]."""
        return {"c10": self.c10, "c01": self.c01, "bulk": self.bulk}

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar."""
        return self.invariant_energy(*invariants(F), parameters)

    def invariant_energy(self, I1: Expr, I2: Expr, J: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(I1, I2, J) [J/m³], equal to `strain_energy`."""
        first, second = isochoric(I1, I2, J)
        return (
            parameters["c10"] * (first - 3)
            + parameters["c01"] * (second - 3)
            + parameters["bulk"] / 2 * (J - 1) ** 2
        )

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of small strains about the rest shape.

        With μ = 2(c10 + c01) and K = bulk, E = 9Kμ/(3K + μ) and ν = (3K − 2μ)/(2(3K + μ)).
        """
        mu = 2.0 * (self.c10 + self.c01)
        total = 3.0 * self.bulk + mu
        return 9.0 * self.bulk * mu / total, (3.0 * self.bulk - 2.0 * mu) / (2.0 * total)

    __eq__ = equal_by_value
    __hash__ = hash_by_value


def _quadratic(strain: Expr, parameters: Mapping[str, Expr]) -> Expr:
    """λ/2 (tr e)² + μ e:e of a symmetric strain e (3, 3)."""
    return parameters["lmbda"] / 2 * ufl.tr(strain) ** 2 + parameters["mu"] * ufl.inner(
        strain, strain
    )
