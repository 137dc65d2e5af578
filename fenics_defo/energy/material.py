"""What a material is to the rest of the package: a density and a strain energy of F."""

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from ufl.core.expr import Expr

from fenics_defo.energy.constants import Constant
from fenics_defo.errors import MaterialError


@runtime_checkable
class Material(Protocol):
    """A hyperelastic solid: all forces follow from ``strain_energy``, all inertia from ``density``.

    Each constant is a float, or a cell field (m,): one value a cell in the order of the mesh file.
    """

    @property
    def density(self) -> Constant:
        """Mass of the rest shape per volume ρ [kg/m³]."""

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """What `strain_energy` needs, by name: Lamé's constants ``mu``, ``lmbda``, for example."""

    def strain_energy(self, F: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(F) [J/m³], a UFL scalar.

        Args:
            F: deformation gradient (3, 3) [-].
            parameters: a UFL scalar for each name of `parameters`, such as a ``fem.Constant``
                or a cell-wise constant function, so that a new value compiles no new kernel.
        """

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio [-] of small strains about the rest shape."""


@runtime_checkable
class IsotropicMaterial(Material, Protocol):
    """A material whose energy is a function of the invariants of C = Fᵀ F alone."""

    def invariant_energy(self, I1: Expr, I2: Expr, J: Expr, parameters: Mapping[str, Expr]) -> Expr:
        """Strain energy per rest volume ψ(I1, I2, J) [J/m³], equal to `strain_energy`."""


def cell_count(material: Material) -> int | None:
    """Number of cells m that the fields of ``material`` cover, or None where all are numbers.

    Raises:
        MaterialError: its fields have different lengths.
    """
    constants = [material.density, *material.parameters.values()]
    lengths = {len(value) for value in constants if not isinstance(value, float)}
    if len(lengths) > 1:
        raise MaterialError(f"the cell fields of {material!r} have different lengths")
    return lengths.pop() if lengths else None
