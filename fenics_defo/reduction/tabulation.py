"""Reduced force laws whose coefficients are computed once and for all."""

from numpy.typing import ArrayLike

from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection
from fenics_defo.reduction.gram_tabulation import (
    EnergyDerivatives,
    check_polynomial,
    strain_derivatives,
)
from fenics_defo.reduction.taylor_tabulation import rest_derivatives
from fenics_defo.runtime.forces.cubic import CubicForce, TaylorForce
from fenics_defo.runtime.forces.linear import LinearForce
from fenics_defo.runtime.forces.symmetric import diagonal_weights


def tabulate_linear(solid: Solid, shapes: ArrayLike) -> LinearForce:
    """The law f = Uᵀ K(0) U q; collective.

    Args:
        solid: body.
        shapes: U (r, n, 3), nodes in the order of the user's file.

    Raises:
        DefoError: shapes that are not the body's, or not finite.
    """
    return LinearForce(Projection(solid, shapes).stiffness_at_rest())


def tabulate_cubic(solid: Solid, shapes: ArrayLike) -> CubicForce:
    """The force of a body of St. Venant-Kirchhoff's and linear laws, exactly; collective.

    See `fenics_defo.reduction.gram_tabulation.strain_derivatives`.

    Args:
        solid: body; any element, any of those laws in its regions.
        shapes: U (r, n, 3), nodes in the order of the user's file.

    Raises:
        DefoError: shapes that are not the body's, or not finite.
        MaterialError: a law whose force is no cubic polynomial.
    """
    check_polynomial(solid)
    return _law(CubicForce, strain_derivatives(solid, Projection(solid, shapes).fields))


def taylor_force(solid: Solid, shapes: ArrayLike) -> TaylorForce:
    """The force of any UFL energy to third order in q about rest; collective.

    How far it may be trusted is measured by `measure_range`. For St. Venant-Kirchhoff it is
    `tabulate_cubic`'s, at a higher cost. See
    `fenics_defo.reduction.taylor_tabulation.rest_derivatives`.

    Args:
        solid: body.
        shapes: U (r, n, 3), nodes in the order of the user's file.

    Raises:
        DefoError: shapes that are not the body's, or not finite.
        MaterialError: a law without an energy in UFL, or without what this needs at rest.
    """
    return _law(TaylorForce, rest_derivatives(solid, Projection(solid, shapes).fields))


def _law[T: CubicForce](kind: type[T], at_rest: EnergyDerivatives) -> T:
    # The law sums over pairs k ≤ l, where each pair k < l stands for two.
    halved = at_rest.fourth * diagonal_weights(len(at_rest.second))
    return kind(at_rest.second, at_rest.third, halved)
