"""Homogeneous deformations of a compressible isotropic solid: nominal stresses in closed form.

All stresses are nominal (first Piola-Kirchhoff): force per area of the rest shape. With the
principal stretches s_i, J = s_1 s_2 s_3, I1 = sum of s_i^2, I2 = sum of s_i^2 s_j^2 (i < j):

    linear, corotational   P_i = 2 mu (s_i - 1) + lambda (s_1 + s_2 + s_3 - 3)
    st-venant-kirchhoff    P_i = s_i (2 mu e_i + lambda (e_1 + e_2 + e_3)),  e_i = (s_i^2 - 1) / 2
    neo-hookean            P_i = mu (s_i - 1 / s_i) + lambda ln J / s_i
    mooney-rivlin          P_i = 2 c10 J^(-2/3) (s_i - I1 / (3 s_i))
                                 + 2 c01 J^(-4/3) (s_i (I1 - s_i^2) - 2 I2 / (3 s_i))
                                 + bulk (J - 1) J / s_i

Sources: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008),
chapter 6; Ogden, Non-Linear Elastic Deformations (1984), chapter 4.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from fenics_defo.beams.checks import BeamError, require_finite, require_modulus, require_positive
from fenics_defo.beams.constants_of_laws import LawConstants, law_constants

type Array = NDArray[np.float64]

# The free stretch is looked for on this grid of its logarithm, outwards from rest.
_STRIDE, _FARTHEST = 0.02, 12.0


@dataclass(frozen=True, slots=True)
class StretchedState:
    """A block stretched along axes while its free sides bear no stress.

    Args:
        stretch: imposed, along x (uniaxial) or along x and y (equibiaxial) [-].
        free_stretch: along the axes that are free of stress [-].
        stress: nominal stress along each stretched axis [Pa].
    """

    stretch: float
    free_stretch: float
    stress: float


@dataclass(frozen=True, slots=True)
class LimitPoint:
    """Where a force stops rising.

    Args:
        stretch: [-].
        stress: nominal stress there [Pa], negative in compression.
    """

    stretch: float
    stress: float


def principal_stresses(law: str, stretches: Array, **constants: float) -> Array:
    """Nominal stresses P_i [Pa], (3,), of the principal stretches (3,), by the module's formulas.

    Args:
        law: "linear", "corotational", "st-venant-kirchhoff", "neo-hookean" or "mooney-rivlin".
        stretches: s_i [-], positive.
        constants: ``young`` [Pa] and ``poisson``; for "mooney-rivlin" ``c10``, ``c01``, ``bulk``
            [Pa].

    Raises:
        BeamError: an unknown law, or a stretch that is not positive.
        MaterialError: a constant is missing, unknown or out of range.
    """
    given = law_constants(law, constants)
    s = np.asarray(stretches, dtype=np.float64)
    if s.shape != (3,) or not (s > 0.0).all() or not np.isfinite(s).all():
        raise BeamError(f"stretches must be three positive finite numbers, got {stretches!r}")
    return _STRESSES[given.law](s, given)


def uniaxial_tension(law: str, *, stretch: float, **constants: float) -> StretchedState:
    """A bar stretched along x with free sides.

    P_2 = P_3 = 0 fixes the lateral stretch t: t = 1 - nu (s - 1) (linear, corotational),
    t^2 = 1 - nu (s^2 - 1) (St. Venant-Kirchhoff), a scalar root for the others. Then the stress is
    E (s - 1), E s (s^2 - 1) / 2, and by the module's formulas.

    Args:
        law: see `principal_stresses`.
        stretch: s [-], positive.
        constants: see `principal_stresses`.

    Raises:
        BeamError: an unknown law, a stretch that is not positive, or one at which the sides have
            no stress-free state (they shrink to nothing).
        MaterialError: a constant is missing, unknown or out of range.
    """
    return _stretched(law, stretch, constants, axes=1)


def equibiaxial_tension(law: str, *, stretch: float, **constants: float) -> StretchedState:
    """A sheet stretched alike along x and y, with free faces.

    P_3 = 0 fixes the stretch t of the thickness: t = 1 - 2 nu / (1 - nu) (s - 1) (linear,
    corotational), t^2 = 1 - 2 nu / (1 - nu) (s^2 - 1) (St. Venant-Kirchhoff), a scalar root for
    the others.

    Args:
        law: see `principal_stresses`.
        stretch: s [-], positive.
        constants: see `principal_stresses`.

    Raises:
        BeamError: an unknown law, a stretch that is not positive, or one at which the faces have
            no stress-free state (the sheet shrinks to nothing).
        MaterialError: a constant is missing, unknown or out of range.
    """
    return _stretched(law, stretch, constants, axes=2)


def simple_shear(law: str, *, amount: float, **constants: float) -> Array:
    """Nominal stress [Pa], (3, 3), of a block sheared by x -> x + g y, all sides held.

    With F = I + g e_x e_y^T. The force on the face y = const is P e_y: P_xy along it and P_yy
    across. Shear strains of second order make normal stresses (Kelvin's and Poynting's effects)
    in all but the linear law:

        linear                P_xy = P_yx = mu g, else 0
        corotational          P = 2 mu (F - R) + 2 lambda (sqrt(1 + g^2 / 4) - 1) R,
                              R the rotation about z by -atan(g / 2)
        st-venant-kirchhoff   P_xy = mu g + (lambda/2 + mu) g^3, P_yx = mu g,
                              P_xx = P_yy = (lambda/2 + mu) g^2, P_zz = lambda g^2 / 2
        neo-hookean           P_xy = P_yx = mu g, else 0
        mooney-rivlin         by dI1/dF = 2 F, dI2/dF = 2 (I1 F - F F^T F), at J = 1

    Args:
        law: see `principal_stresses`.
        amount: g, the tangent of the angle of shear [-], of either sign.
        constants: see `principal_stresses`.

    Raises:
        BeamError: an unknown law, or an amount that is not finite.
        MaterialError: a constant is missing, unknown or out of range.
    """
    given = law_constants(law, constants)
    g = require_finite("amount", amount, unit="-")
    F = np.eye(3)
    F[0, 1] = g
    return _SHEARS[given.law](F, g, given)


def compressive_limit(*, young: float) -> LimitPoint:
    """Where a St. Venant-Kirchhoff bar's resistance to compression ends: s = 1 / sqrt(3).

    P = E s (s^2 - 1) / 2 has its extremum -E / (3 sqrt(3)) there; below it the force falls although
    the bar is pressed further. With sides held instead of free, the stretch is the same and
    lambda + 2 mu stands for E.

    Args:
        young: E [Pa].

    Raises:
        MaterialError: Young's modulus is out of range.

    References:
        Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008), on the
        limits of the St. Venant-Kirchhoff material.
    """
    modulus = require_modulus("young", young, unit="Pa")
    return LimitPoint(1.0 / sqrt(3.0), -modulus / (3.0 * sqrt(3.0)))


def _stretched(
    law: str, stretch: float, constants: dict[str, float], *, axes: int
) -> StretchedState:
    given = law_constants(law, constants)
    s = require_positive("stretch", stretch, unit="-")

    def stresses(free: float) -> Array:
        return _STRESSES[given.law](np.array([s, s if axes == 2 else free, free]), given)

    contraction = given.poisson if axes == 1 else 2.0 * given.poisson / (1.0 - given.poisson)
    if given.law in ("linear", "corotational"):
        free = 1.0 - contraction * (s - 1.0)
    elif given.law == "st-venant-kirchhoff":
        squared = 1.0 - contraction * (s**2 - 1.0)
        free = sqrt(max(squared, 0.0))
    else:
        guess = -contraction * log(s)
        free = _stress_free(lambda t: float(stresses(t)[2]), guess)
    if not free > 0.0:
        raise BeamError(
            f"at the stretch {s:g} the free sides of the law {law!r} shrink to nothing; "
            "choose a stretch nearer to 1"
        )
    return StretchedState(s, free, float(stresses(free)[0]))


def _stress_free(stress: Callable[[float], float], guess: float) -> float:
    """The stretch at which ``stress``, which grows with it on the stable branch, vanishes.

    Its logarithm is followed from ``guess`` up while the stress is negative, down while positive.
    """
    way = -1.0 if stress(exp(guess)) > 0.0 else 1.0
    here = guess
    while abs(here - guess) < _FARTHEST:
        ahead = here + way * _STRIDE
        if way * stress(exp(ahead)) >= 0.0:
            root = brentq(lambda at: stress(exp(at)), here, ahead, xtol=1e-16, rtol=1e-15)
            return exp(float(root))
        here = ahead
    return 0.0


def _hookean(s: Array, given: LawConstants) -> Array:
    return 2.0 * given.mu * (s - 1.0) + given.lmbda * (s.sum() - 3.0)


def _st_venant_kirchhoff(s: Array, given: LawConstants) -> Array:
    strain = 0.5 * (s - 1.0) * (s + 1.0)
    return s * (2.0 * given.mu * strain + given.lmbda * strain.sum())


def _neo_hookean(s: Array, given: LawConstants) -> Array:
    return given.mu * (s - 1.0 / s) + given.lmbda * np.log(s).sum() / s


def _mooney_rivlin(s: Array, given: LawConstants) -> Array:
    square, J = s**2, s.prod()
    first = square.sum()
    second = 0.5 * (first**2 - (square**2).sum())
    return (
        2.0 * given.c10 * J ** (-2.0 / 3.0) * (s - first / (3.0 * s))
        + 2.0 * given.c01 * J ** (-4.0 / 3.0) * (s * (first - square) - 2.0 * second / (3.0 * s))
        + given.bulk * (J - 1.0) * J / s
    )


_STRESSES = {
    "linear": _hookean,
    "corotational": _hookean,
    "st-venant-kirchhoff": _st_venant_kirchhoff,
    "neo-hookean": _neo_hookean,
    "mooney-rivlin": _mooney_rivlin,
}


def _shear_along(F: Array, g: float, given: LawConstants) -> Array:
    """Mu g in both places: J = 1 and tr(F) = 3 leave nothing else."""
    stress = np.zeros_like(F)
    stress[0, 1] = stress[1, 0] = given.mu * g
    return stress


def _shear_corotational(F: Array, g: float, given: LawConstants) -> Array:
    stretched = sqrt(1.0 + 0.25 * g**2)
    cosine, sine = 1.0 / stretched, 0.5 * g / stretched
    R = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    # sqrt(1 + g^2 / 4) - 1 without cancellation.
    excess = 0.25 * g**2 / (1.0 + stretched)
    return 2.0 * given.mu * (F - R) + 2.0 * given.lmbda * excess * R


def _shear_st_venant_kirchhoff(F: Array, g: float, given: LawConstants) -> Array:
    volumetric = 0.5 * given.lmbda * g**2
    second = np.diag([volumetric, volumetric + given.mu * g**2, volumetric])
    second[0, 1] = second[1, 0] = given.mu * g
    return F @ second


def _shear_mooney_rivlin(F: Array, g: float, given: LawConstants) -> Array:
    inverse = np.linalg.inv(F).T
    invariant = 3.0 + g**2  # I1 = I2
    return 2.0 * given.c10 * (F - invariant / 3.0 * inverse) + 2.0 * given.c01 * (
        invariant * F - F @ F.T @ F - 2.0 / 3.0 * invariant * inverse
    )


_SHEARS = {
    "linear": _shear_along,
    "corotational": _shear_corotational,
    "st-venant-kirchhoff": _shear_st_venant_kirchhoff,
    "neo-hookean": _shear_along,
    "mooney-rivlin": _shear_mooney_rivlin,
}
