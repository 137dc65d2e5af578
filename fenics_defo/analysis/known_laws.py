"""What is known of the laws that a body is made of."""

from collections.abc import Mapping
from typing import Any

from fenics_defo.energy import (
    Corotational,
    Invertible,
    LinearElastic,
    MassSpring,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)

# Laws whose energy is finite where their stress is: powers and logarithms of det F are in both.
_FINITE = (
    LinearElastic,
    StVenantKirchhoff,
    NeoHookean,
    MooneyRivlin,
    Corotational,
    Invertible,
    MassSpring,
)


def laws_of(materials: Any) -> tuple[Any, ...]:
    """The laws of a body of one material, or of a mapping of regions to materials."""
    return tuple(materials.values()) if isinstance(materials, Mapping) else (materials,)


def has_finite_energy(materials: Any) -> bool:
    """Whether the strain energy is sure to be a number wherever the forces are."""
    return all(isinstance(law, _FINITE) for law in laws_of(materials))


def has_exact_tangents(materials: Any) -> bool:
    """Whether all tangents are derivatives of the forces, not definite stand-ins for them."""
    return all(getattr(law, "tangent", "exact") == "exact" for law in laws_of(materials))
