"""Strain measures and invariants of the deformation gradient F = I + ∂u/∂X, as UFL expressions.

All are of 3 × 3 tensors. Source: Holzapfel, Nonlinear Solid Mechanics (2000), chapters 2 and 6.
"""

import ufl
from ufl.core.expr import Expr


def deformation_gradient(displacement: Expr) -> Expr:
    """F = I + grad u (3, 3) [-], as a UFL variable: stresses are derivatives with respect to it."""
    return ufl.variable(ufl.Identity(3) + ufl.grad(displacement))


def right_cauchy_green(F: Expr) -> Expr:
    """C = Fᵀ F (3, 3) [-]."""
    return F.T * F


def green_lagrange(F: Expr) -> Expr:
    """E = (Fᵀ F − I)/2 (3, 3) [-], zero under any rigid motion.

    Of F = I + H written as such, as sym H + Hᵀ H/2: strains of 1e-6 then keep all their digits.
    """
    H = _displacement_gradient(F)
    if H is None:
        return (right_cauchy_green(F) - ufl.Identity(3)) / 2
    return ufl.sym(H) + H.T * H / 2


def small_strain(F: Expr) -> Expr:
    """ε = sym(F) − I (3, 3) [-], zero under small rotations only; of F = I + H, sym H."""
    H = _displacement_gradient(F)
    return ufl.sym(F) - ufl.Identity(3) if H is None else ufl.sym(H)


def _displacement_gradient(F: Expr) -> Expr | None:
    """H where F is the sum I + H; None where it is anything else, a variable too."""
    if isinstance(F, ufl.classes.Sum):
        first, second = F.ufl_operands
        for one, other in ((first, second), (second, first)):
            if isinstance(one, ufl.classes.Identity):
                return other
    return None


def invariants(F: Expr) -> tuple[Expr, Expr, Expr]:
    """Invariants (I1, I2, J) [-] of C = Fᵀ F, equal to (3, 3, 1) at rest.

    I1 = tr C, I2 = ((tr C)² − tr C²)/2 and J = det F, so that I3 = J².
    """
    C = right_cauchy_green(F)
    first = ufl.tr(C)
    # C is symmetric: tr C² = C : C, without the matrix product.
    return first, (first**2 - ufl.inner(C, C)) / 2, ufl.det(F)


def isochoric(I1: Expr, I2: Expr, J: Expr) -> tuple[Expr, Expr]:
    """Invariants (J^(−2/3) I1, J^(−4/3) I2) [-] of the volume-preserving part J^(−1/3) F."""
    return J ** (-2.0 / 3.0) * I1, J ** (-4.0 / 3.0) * I2


def isochoric_invariants(F: Expr) -> tuple[Expr, Expr, Expr]:
    """Modified invariants (J^(−2/3) I1, J^(−4/3) I2, J) [-] of F; the first two ignore dilation."""
    I1, I2, J = invariants(F)
    return *isochoric(I1, I2, J), J
