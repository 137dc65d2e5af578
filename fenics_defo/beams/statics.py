"""Static deflection, extension, twist and buckling of uniform straight beams.

Loads and deflections are small, so they superpose.
"""

from dataclasses import dataclass
from math import pi, tan

from scipy.optimize import brentq

from fenics_defo.beams.checks import (
    require_choice,
    require_finite,
    require_modulus,
    require_positive,
    shear_modulus,
)
from fenics_defo.beams.sections import Section, resolve_shear_coefficient, second_moment
from fenics_defo.beams.stepped import BEAM_THEORIES


@dataclass(frozen=True, slots=True)
class TipDeflection:
    """Where the free end of a cantilever goes.

    Args:
        deflection: across the axis [m].
        rotation: of the end section [rad].
    """

    deflection: float
    rotation: float


def cantilever_tip(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    force: float = 0.0,
    moment: float = 0.0,
    line_load: float = 0.0,
    direction: str = "z",
    theory: str = "timoshenko",
    shear: str | float = "cowper",
) -> TipDeflection:
    """Tip of a cantilever under an end force F, an end moment M and a uniform line load q.

    w = F L^3/(3EI) + M L^2/(2EI) + q L^4/(8EI) + (F L + q L^2/2)/(kappa G A),
    psi = F L^2/(2EI) + M L/(EI) + q L^3/(6EI); Euler-Bernoulli leaves out the shear term.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        force: F at the tip, along ``direction`` [N].
        moment: M at the tip, positive if it bends the tip along ``direction`` [N m].
        line_load: q along ``direction`` [N/m].
        direction: "y" or "z".
        theory: "timoshenko" or "euler-bernoulli".
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-].

    Returns:
        Deflection [m] and rotation [rad] of the tip.

    Raises:
        BeamError: a length, load, direction, theory or shear rule is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko, Strength of Materials, part I, deflection of beams and effect of shear.
    """
    span = require_positive("length", length, unit="m")
    bending, flexibility = _stiffnesses(section, young, poisson, direction, theory, shear)
    end, couple = (
        require_finite("force", force, unit="N"),
        require_finite("moment", moment, unit="N m"),
    )
    spread = require_finite("line_load", line_load, unit="N/m") * span
    bent = span**2 / bending * (end * span / 3.0 + couple / 2.0 + spread * span / 8.0)
    sheared = (end + 0.5 * spread) * span * flexibility
    rotation = span / bending * (end * span / 2.0 + couple + spread * span / 6.0)
    return TipDeflection(bent + sheared, rotation)


def midspan_deflection(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    supports: str,
    force: float = 0.0,
    line_load: float = 0.0,
    direction: str = "z",
    theory: str = "timoshenko",
    shear: str | float = "cowper",
) -> float:
    """Middle of a beam on two supports under a force F there and a uniform line load q.

    Pinned-pinned: F L^3/(48EI) + 5 q L^4/(384EI); clamped-clamped: F L^3/(192EI) + q L^4/(384EI);
    in both, shear adds (F L/4 + q L^2/8)/(kappa G A).

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        supports: "pinned-pinned" or "clamped-clamped".
        force: F at the middle, along ``direction`` [N].
        line_load: q along ``direction`` [N/m].
        direction: "y" or "z".
        theory: "timoshenko" or "euler-bernoulli".
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-].

    Returns:
        Deflection [m].

    Raises:
        BeamError: a length, load, support, direction, theory or shear rule is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko, Strength of Materials, part I, deflection of beams and effect of shear.
    """
    pinned = require_choice("supports", supports, ("pinned-pinned", "clamped-clamped"))
    by_force, by_load = (8.0, 5.0) if pinned == "pinned-pinned" else (2.0, 1.0)
    span = require_positive("length", length, unit="m")
    bending, flexibility = _stiffnesses(section, young, poisson, direction, theory, shear)
    centre = require_finite("force", force, unit="N")
    spread = require_finite("line_load", line_load, unit="N/m") * span
    bent = span**3 / (384.0 * bending) * (by_force * centre + by_load * spread)
    return bent + (centre / 4.0 + spread / 8.0) * span * flexibility


def axial_elongation(*, length: float, section: Section, young: float, force: float) -> float:
    """Extension F L / (E A) [m] of a bar pulled by ``force`` F [N].

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        force: F [N], positive in tension.

    Raises:
        BeamError: the length or the force is not allowed.
        MaterialError: Young's modulus is out of range.

    References:
        Timoshenko, Strength of Materials, part I, tension within the elastic limit.
    """
    stiffness = require_modulus("young", young, unit="Pa") * section.area
    pull = require_finite("force", force, unit="N")
    return pull * require_positive("length", length, unit="m") / stiffness


def twist_angle(
    *, length: float, section: Section, young: float, poisson: float, torque: float
) -> float:
    """End rotation T L / (G J) [rad] of a bar twisted by ``torque`` T [N m]; warping is free.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        torque: T [N m].

    Raises:
        BeamError: the length or the torque is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko and Goodier, Theory of Elasticity, chapter on torsion.
    """
    stiffness = shear_modulus(young, poisson) * section.torsion_constant
    couple = require_finite("torque", torque, unit="N m")
    return couple * require_positive("length", length, unit="m") / stiffness


def buckling_load(
    *,
    length: float,
    section: Section,
    young: float,
    supports: str = "clamped-free",
    direction: str | None = None,
) -> float:
    """Euler's least critical compressive force E I (x / L)^2 [N] of a slender column.

    x = pi/2 clamped-free, pi pinned-pinned, 2 pi clamped-clamped, and the least root 4.4934 of
    tan x = x clamped-pinned. The load keeps its direction.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        supports: one of these four pairs.
        direction: "y" or "z", in which the column bows; None for the weaker one.

    Raises:
        BeamError: a length, support or direction is not allowed.
        MaterialError: Young's modulus is out of range.

    References:
        Timoshenko and Gere, Theory of Elastic Stability, chapter 2.
    """
    roots = {
        "clamped-free": 0.5 * pi,
        "pinned-pinned": pi,
        "clamped-clamped": 2.0 * pi,
        "clamped-pinned": brentq(lambda x: tan(x) - x, 4.4, 4.6, xtol=1e-14),
    }
    root = roots[require_choice("supports", supports, roots)]
    span = require_positive("length", length, unit="m")
    if direction is None:
        moment = min(section.second_moment_y, section.second_moment_z)
    else:
        moment = second_moment(section, direction)
    return require_modulus("young", young, unit="Pa") * moment * float(root / span) ** 2


def _stiffnesses(
    section: Section,
    young: float,
    poisson: float,
    direction: str,
    theory: str,
    shear: str | float,
) -> tuple[float, float]:
    """E I [N m^2] and 1 / (kappa G A) [1/N], the latter zero for Euler-Bernoulli."""
    modulus = shear_modulus(young, poisson)
    bending = float(young) * second_moment(section, direction)
    if require_choice("theory", theory, BEAM_THEORIES) == "euler-bernoulli":
        return bending, 0.0
    kappa = resolve_shear_coefficient(section, poisson, shear)
    return bending, 1.0 / (kappa * modulus * section.area)
