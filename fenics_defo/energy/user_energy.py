"""The user's own strain energies: a function that returns a UFL scalar, and its constants."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ufl.constantvalue import as_ufl
from ufl.core.expr import Expr

from fenics_defo.energy.constants import Constant, check_lengths, finite, positive
from fenics_defo.energy.kinematics import invariants
from fenics_defo.energy.rest_state import linear_moduli
from fenics_defo.errors import MaterialError


@dataclass(frozen=True, slots=True, eq=False)
class HyperelasticEnergy:
    """A solid with the user's strain energy ψ(F); anisotropic ones too.

    Args:
        function: takes F (3, 3) and a mapping from each name of ``constants`` to a UFL scalar;
            returns the strain energy per rest volume ψ [J/m³], a UFL scalar. It should depend on
            F through Fᵀ F only: else rigid rotations store energy.
        constants: its numbers, each a float, or (m,) numbers, one a cell. A number written into
            ``function`` instead becomes part of the compiled code.
        density: mass of the rest shape per volume ρ [kg/m³], positive.

    Raises:
        MaterialError: a constant is not finite, or fields have different lengths.
    """

    function: Callable[[Expr, Mapping[str, Expr]], Expr]
    constants: Mapping[str, Constant] = field(default_factory=dict)
    density: Constant = field(kw_only=True)

    def __post_init__(self) -> None:
        _store(self, self.function, self.constants, self.density)

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """The user's constants."""
        return self.constants

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar.

        Raises:
            MaterialError: the function does not return a scalar.
        """
        return _scalar(self.function(F, parameters))

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of ∂²ψ/∂F² at F = I.

        Raises:
            MaterialError: see `linear_moduli`; above all, ψ is stressed or anisotropic at rest.
        """
        return linear_moduli(self)


@dataclass(frozen=True, slots=True, eq=False)
class IsotropicEnergy:
    """A solid with the user's strain energy ψ(I1, I2, J) of the invariants of C = Fᵀ F.

    Args:
        function: takes I1, I2, J (see `invariants`; 3, 3, 1 at rest) and a mapping from each name
            of ``constants`` to a UFL scalar; returns the strain energy per rest volume ψ [J/m³].
        constants: its numbers, each a float, or (m,) numbers, one a cell. A number written into
            ``function`` instead becomes part of the compiled code.
        density: mass of the rest shape per volume ρ [kg/m³], positive.

    Raises:
        MaterialError: a constant is not finite, or fields have different lengths.
    """

    function: Callable[[Expr, Expr, Expr, Mapping[str, Expr]], Expr]
    constants: Mapping[str, Constant] = field(default_factory=dict)
    density: Constant = field(kw_only=True)

    def __post_init__(self) -> None:
        _store(self, self.function, self.constants, self.density)

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """The user's constants."""
        return self.constants

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar.

        Raises:
            MaterialError: the function does not return a scalar.
        """
        return self.invariant_energy(*invariants(F), parameters)

    def invariant_energy(self, I1: Expr, I2: Expr, J: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(I1, I2, J) [J/m³], equal to `strain_energy`.

        Raises:
            MaterialError: the function does not return a scalar.
        """
        return _scalar(self.function(I1, I2, J, parameters))

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of ∂²ψ/∂F² at F = I.

        Raises:
            MaterialError: see `linear_moduli`; above all, ψ is stressed at rest.
        """
        return linear_moduli(self)


def _store(
    record: object, function: object, constants: Mapping[str, Constant], density: Constant
) -> None:
    """Put the checked constants and density into the frozen ``record``."""
    if not callable(function):
        raise MaterialError(
            f"the energy must be a function that returns a UFL scalar, got {function!r}"
        )
    if not isinstance(constants, Mapping) or not all(isinstance(n, str) for n in constants):
        raise MaterialError(
            f"constants must map names to numbers, such as {{'mu': 1e6}}, got {constants!r}"
        )
    checked = {name: finite(name, value) for name, value in constants.items()}
    density = positive("density", density, unit="kg/m³")
    check_lengths({**checked, "density": density})
    object.__setattr__(record, "constants", MappingProxyType(checked))
    object.__setattr__(record, "density", density)


def _scalar(energy: object) -> Expr:
    try:
        expression = as_ufl(energy)
    except ValueError:
        raise MaterialError(
            f"the energy function must return a UFL scalar, got {energy!r}; "
            "use ufl.ln, ufl.det, ... and not their namesakes in math or NumPy"
        ) from None
    if expression.ufl_shape or expression.ufl_free_indices:
        raise MaterialError(
            f"the energy function must return a scalar, got shape {expression.ufl_shape} and "
            f"{len(expression.ufl_free_indices)} free indices; "
            "contract the tensors, with ufl.tr or ufl.inner for example"
        )
    return expression
