"""A body of springs between the nodes of its cells."""

from collections.abc import Mapping
from dataclasses import dataclass

from fenics_defo.energy.constants import Constant, equal_by_value, hash_by_value, positive, store

#: Poisson's ratio of springs of all directions alike: central forces make λ = μ (Cauchy).
POISSON = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MassSpring:
    """Springs between the corner nodes of each cell, and the cells' masses lumped at the nodes.

    ψ of a spring is k/2 (l − L)² with L its length at rest. How k follows from E and the cells is
    said at `fenics_defo.runtime.laws.cell_springs`. The network is that of an isotropic solid of
    Young's modulus E where the springs have no preferred direction; its Poisson's ratio is then
    1/4, and no other can be had.

    Args:
        young: Young's modulus E [Pa], positive.
        density: mass of the rest shape per volume ρ [kg/m³], positive.

    Raises:
        MaterialError: a constant is out of its range, or fields have different lengths.
    """

    young: Constant
    density: Constant

    def __post_init__(self) -> None:
        store(
            self,
            {
                "young": positive("young", self.young, unit="Pa"),
                "density": positive("density", self.density, unit="kg/m³"),
            },
        )

    @property
    def parameters(self) -> Mapping[str, Constant]:
        """Young's modulus ``young`` [Pa]."""
        return {"young": self.young}

    def linearised(self) -> tuple[Constant, Constant]:
        """Young's modulus [Pa] and Poisson's ratio 1/4 of a network without preferred direction."""
        return self.young, self.young * 0.0 + POISSON

    __eq__ = equal_by_value
    __hash__ = hash_by_value
