"""What a body's energy, force and stiffness are sums of."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import MassSpring, Material
from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.forms import BodyForms
from fenics_defo.fem.material_fields import MaterialFields
from fenics_defo.fem.point_part import PointPart
from fenics_defo.fem.spring_part import SpringPart
from fenics_defo.fem.ufl_part import UflPart

Array = NDArray[np.float64]


class Part(Protocol):
    """Cells, or springs, of one kind of law; each of its own on exactly one rank."""

    def energy(self, local: Array) -> float:
        """This rank's share of the strain energy [J] at a displacement (d, 3) [m]."""

    def add_force(self, local: Array, force: Array) -> None:
        """Add this rank's share of the internal force to (d, 3) [N]."""

    def add_tangent(self, local: Array, blocks: BlockMatrix, force: Array | None) -> None:
        """Add this rank's share of the tangent, and of the force where an array is given for it."""


@runtime_checkable
class SmoothPart(Part, Protocol):
    """A part whose third derivatives are known."""

    def add_tangent_derivative(self, local: Array, direction: Array, blocks: BlockMatrix) -> None:
        """Add this rank's share of the tangent's derivative along a displacement (d, 3)."""


@runtime_checkable
class SampledPart(Part, Protocol):
    """A part whose third derivatives are found by differences of its tangent."""

    def with_exact_tangent(self) -> "SampledPart":
        """The same part with the derivative of its force as tangent."""

    def steepest(self, direction: Array) -> float:
        """Largest entry of the gradient [-] of a displacement (d, 3), on this rank."""


def body_parts(
    space: "dolfinx.fem.FunctionSpace", forms: BodyForms, fields: MaterialFields, degree: int
) -> tuple[tuple[Part, ...], tuple[Part, ...]]:
    """The parts of a body, and those of them that its ``rest_tangent`` lacks.

    Args:
        space: displacement space.
        forms: the body's.
        fields: its laws.
        degree: that the quadrature at points integrates exactly.

    Raises:
        MaterialError: a law does not go with the space.
    """
    parts: list[Part] = [] if forms.strain is None else [UflPart(forms.strain)]
    unformed: list[Part] = []
    for region in fields.regions:
        if isinstance(region.material, Material):
            continue
        springs = isinstance(region.material, MassSpring)
        part = SpringPart(space, region) if springs else PointPart(space, region, degree)
        parts.append(part)
        if region.rest_moduli is None:
            unformed.append(part)
    return tuple(parts), tuple(unformed)
