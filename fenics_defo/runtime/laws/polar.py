"""The rotation in batches of 3 × 3 deformation gradients."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import (
    batches,
    cofactor,
    components,
    inner,
    product,
    transpose,
)
from fenics_defo.runtime.laws.svd3 import svd_components

type Array = NDArray[np.float64]

_STEPS = 12
# Relative step of Newton's iteration for the trace after which its error is its square.
_CLOSE = 1e-6
# Divisor of the closed form relative to (s1 + s2 + s3)³ below which it loses too many digits, and
# the singular vectors are asked for.
_HARD = 1e-3


def polar_rotation(F: Array) -> Array:
    """The proper rotation R nearest to F, which makes tr(Rᵀ F) largest.

    R = U Vᵀ with the singular vectors of `signed_svd`. It is unique where the two smaller signed
    stretches have a sum above zero; elsewhere (rank one, or inverted with |s3| = s2) one of the
    nearest rotations is taken.

    Args:
        F: (m, 3, 3); singular and inverted ones too.

    Returns:
        R (m, 3, 3), det R = 1; NaN where F has NaN.
    """
    R = np.empty((len(F), 3, 3))
    for part in batches(len(F)):
        R[part] = polar_components(components(F[part])).transpose(2, 0, 1)
    return R


def polar_components(F: Array) -> Array:
    """`polar_rotation` of one batch, components first: R (3, 3, b).

    The trace t = tr(Rᵀ F) = s1 + s2 + s3 is the largest root of t⁴ − 2 I1 t² − 8 J t + I1² − 4 I2
    with the invariants (I1, I2, J) of F (the characteristic polynomial of Davenport's 4 × 4
    matrix), and R = ∂t/∂F by implicit differentiation:

        R = ((t² + I1) F − 2 F Fᵀ F + 2 t cof F)/(t³ − I1 t − 2 J),

    whose divisor is 2 (s1 + s2)(s1 + s3)(s2 + s3). An error of t leaves the singular vectors of R
    as they are; a Newton-Schulz step R ← R (3 I − Rᵀ R)/2 removes it.
    """
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        C = product(transpose(F), F)
        cofactors = cofactor(F)
        J = inner(F[0], cofactors[0])
        I1 = C[0, 0] + C[1, 1] + C[2, 2]
        trace, close = _largest_root(I1, inner(cofactors, cofactors), J)
        squared = trace * trace
        divisor = trace * (squared - I1) - 2.0 * J
        R = (squared + I1) * F
        R -= 2.0 * product(F, C)
        R += (2.0 * trace) * cofactors
        R /= divisor
        R = 1.5 * R - product(R, 0.5 * product(transpose(R), R))
        hard = np.flatnonzero(~(close & (divisor > _HARD * squared * trace)))
    if hard.size:
        U, _, V = svd_components(F[:, :, hard])
        R[:, :, hard] = product(U, transpose(V))
    return R


def _largest_root(I1: Array, I2: Array, J: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Largest root of t⁴ − 2 I1 t² − 8 J t + I1² − 4 I2, and where it has been found.

    Newton's iteration from above: t² ≤ 3 I1, and the polynomial is convex beyond its largest root.
    """
    constant = I1 * I1 - 4.0 * I2
    root = np.sqrt(3.0 * I1)
    for _ in range(_STEPS):
        squared = root * root
        slope = 4.0 * (root * (squared - I1) - 2.0 * J)
        value = squared * (squared - 2.0 * I1) - (8.0 * J) * root + constant
        step = value / slope
        root -= step
        close = np.abs(step) <= _CLOSE * root
        if close.all():
            break
    return root, close
