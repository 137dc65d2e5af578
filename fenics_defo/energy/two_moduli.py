"""Constants shared by the laws of two moduli."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from fenics_defo.energy.constants import (
    Constant,
    check_lengths,
    equal_by_value,
    finite,
    hash_by_value,
    positive,
    store,
    within,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TwoModuli:
    """Constants of an isotropic solid; each a number, or (m,) numbers, one a cell.

    Args:
        young: Young's modulus E [Pa], positive.
        poisson: Poisson's ratio ν [-], strictly between -1 and 0.5.
        density: mass of the rest shape per volume ρ [kg/m³], positive.

    Raises:
        MaterialError: a constant is out of its range, or fields have different lengths.
    """

    young: Constant
    poisson: Constant
    density: Constant

    def __post_init__(self) -> None:
        constants = {
            "young": positive("young", self.young, unit="Pa"),
            "poisson": within(
                "poisson",
                self.poisson,
                low=-1.0,
                high=0.5,
                allowed="lie strictly between -1 and 0.5 (use 0.49 where volume hardly changes)",
            ),
            "density": positive("density", self.density, unit="kg/m³"),
        }
        store(self, constants)

    @classmethod
    def from_lame(
        cls, *, mu: Constant, lmbda: Constant, density: Constant, **options: object
    ) -> Self:
        """The same solid from Lamé's constants.

        E = μ(3λ + 2μ)/(λ + μ) and ν = λ/(2(λ + μ)). Only E and ν are kept: `parameters` gives
        λ back to about 1e-16 λ/μ, relatively.

        Args:
            mu: shear modulus μ [Pa], positive.
            lmbda: Lamé's first constant λ [Pa], above -2/3 μ.
            density: mass of the rest shape per volume ρ [kg/m³], positive.
            options: what else the law's record takes.

        Raises:
            MaterialError: a constant is out of its range, or fields have different lengths.
        """
        mu = positive("mu", mu, unit="Pa")
        lmbda = finite("lmbda", lmbda)
        check_lengths({"mu": mu, "lmbda": lmbda})
        within(
            "the bulk modulus lmbda + 2/3 mu",
            lmbda + 2.0 / 3.0 * mu,
            low=0.0,
            allowed="be positive [Pa]",
        )
        return cls(
            young=mu * (3.0 * lmbda + 2.0 * mu) / (lmbda + mu),
            poisson=lmbda / (2.0 * (lmbda + mu)),
            density=density,
            **options,
        )

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """Lamé's constants: ``mu`` = E/(2(1 + ν)) and ``lmbda`` = Eν/((1 + ν)(1 − 2ν)) [Pa]."""
        mu = self.young / (2.0 * (1.0 + self.poisson))
        lmbda = self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
        return {"mu": mu, "lmbda": lmbda}

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of small strains about the rest shape."""
        return self.young, self.poisson

    __eq__ = equal_by_value
    __hash__ = hash_by_value
