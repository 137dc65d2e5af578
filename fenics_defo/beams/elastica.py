"""Large deflections of an inextensible slender cantilever: Euler's elastica.

The undeformed axis is x from the clamp; the beam bends towards positive y. Strains stay small,
rotations do not; shear and extension are neglected.
"""

from dataclasses import dataclass
from math import atan2, exp, log, sin, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from fenics_defo.beams.checks import BeamError, require_finite, require_modulus, require_positive
from fenics_defo.beams.sections import Section, second_moment

# Up to here exp(-sqrt(2 load)), the distance of the tip's angle from a right angle, is a number.
_LARGEST_LOAD = 1.0e5


@dataclass(frozen=True, slots=True)
class TipPose:
    """The free end of a bent cantilever.

    Args:
        x: distance from the clamp along the undeformed axis [m].
        y: distance from the undeformed axis [m].
        rotation: of the tangent [rad].
    """

    x: float
    y: float
    rotation: float


def elastica_end_force(
    *, length: float, section: Section, young: float, force: float, direction: str = "z"
) -> TipPose:
    """Cantilever under a dead end force F across its undeformed axis.

    E I theta'' = -F cos theta, theta(0) = 0, theta'(L) = 0. With S = sin theta(L) and Carlson's
    integrals a = R_F(1 - S^2, 1 + S, 1 - S), d = R_D(1 + S, 1 - S, 1 - S^2), the first integral of
    that equation gives

        F L^2 / (E I) = 2 S a^2,   x = L / a,   y = L S (1 - (1 - S^2) d / (3 a)),

    the solution in elliptic integrals of Bisshopp and Drucker without its differences of large
    numbers: small loads and loads that pull the beam straight lose no digits.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        force: F along ``direction`` [N], of either sign.
        direction: "y" or "z".

    Returns:
        Pose of the tip; y and rotation have the sign of the force.

    Raises:
        BeamError: a length, force or direction is not allowed, or F L^2 / (E I) exceeds 1e5.
        MaterialError: Young's modulus is out of range.

    References:
        Bisshopp and Drucker, Q. Appl. Math. 3 (1945) 272; Carlson's integrals: NIST Digital Library
        of Mathematical Functions, section 19.16.
    """
    span, stiffness = _span_and_stiffness(length, section, young, direction)
    load = require_finite("force", force, unit="N") * span**2 / stiffness
    if load == 0.0:
        return TipPose(span, 0.0, 0.0)
    if not abs(load) <= _LARGEST_LOAD:
        raise BeamError(
            f"force L^2 / (E I) must be at most {_LARGEST_LOAD:g} in size, got {load:g}; "
            "beyond it the beam is a straight string but for a bend at the clamp"
        )
    sine, rest = _tip_sine(abs(load))
    first, second = _carlson(sine, rest)
    squared_cosine = rest * (1.0 + sine)
    sign = 1.0 if load > 0.0 else -1.0
    height = sine * (1.0 - squared_cosine * second / (3.0 * first))
    return TipPose(span / first, sign * span * height, sign * atan2(sine, sqrt(squared_cosine)))


def elastica_end_moment(
    *, length: float, section: Section, young: float, moment: float, direction: str = "z"
) -> TipPose:
    """Cantilever rolled up by an end moment M into an arc of curvature M / (E I).

    theta = M L / (E I), x = L sin theta / theta, y = L (1 - cos theta) / theta; theta = 2 pi closes
    the circle.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        moment: M [N m], of either sign, bending towards ``direction`` when positive.
        direction: "y" or "z".

    Returns:
        Pose of the tip.

    Raises:
        BeamError: a length, moment or direction is not allowed.
        MaterialError: Young's modulus is out of range.

    References:
        Love, A Treatise on the Mathematical Theory of Elasticity, chapter XIX.
    """
    span, stiffness = _span_and_stiffness(length, section, young, direction)
    angle = require_finite("moment", moment, unit="N m") * span / stiffness
    half = float(np.sinc(0.5 * angle / np.pi))  # chord / arc; sin x / x, 1 at zero
    return TipPose(span * float(np.sinc(angle / np.pi)), span * half * sin(0.5 * angle), angle)


def _span_and_stiffness(
    length: float, section: Section, young: float, direction: str
) -> tuple[float, float]:
    bending = require_modulus("young", young, unit="Pa") * second_moment(section, direction)
    return require_positive("length", length, unit="m"), bending


def _carlson(sine: float, rest: float) -> tuple[float, float]:
    """A and d of `elastica_end_force`, from S and 1 - S."""
    squared_cosine = rest * (1.0 + sine)
    return (
        float(elliprf(squared_cosine, 1.0 + sine, rest)),
        float(elliprd(1.0 + sine, rest, squared_cosine)),
    )


def _tip_sine(load: float) -> tuple[float, float]:
    """S and 1 - S, each to full accuracy, of the load F L^2 / (E I) = 2 S a(S)^2 > 0.

    The unknown is log(S / (1 - S)), in which both ends of the range are far away.
    """

    def parts(logit: float) -> tuple[float, float]:
        small = 1.0 / (1.0 + exp(abs(logit)))
        large = 1.0 / (1.0 + exp(-abs(logit)))
        return (large, small) if logit > 0.0 else (small, large)

    def excess(logit: float) -> float:
        sine, rest = parts(logit)
        return log(sine) + 2.0 * log(_carlson(sine, rest)[0]) - log(0.5 * load)

    return parts(float(brentq(excess, -700.0, 700.0, xtol=1e-15, rtol=1e-15)))
