"""Natural frequencies of uniform straight beams and bars.

Bending is in one principal plane; `direction` names the axis along which the beam deflects.
Free ends leave rigid motions: their zero frequencies are not among the results.
"""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.beams.checks import (
    require_count,
    require_modulus,
    require_positive,
    shear_modulus,
)
from fenics_defo.beams.dynamic_stiffness import natural_frequencies
from fenics_defo.beams.roots import bar_roots, bending_roots
from fenics_defo.beams.sections import Section, second_moment
from fenics_defo.beams.stepped import Segment, beam_piece
from fenics_defo.beams.supports import beam_supports

type Array = NDArray[np.float64]


def euler_bernoulli_frequencies(
    *,
    length: float,
    section: Section,
    young: float,
    density: float,
    count: int,
    supports: str = "clamped-free",
    direction: str = "z",
) -> Array:
    """Bending frequencies of a slender beam, (beta L)^2 sqrt(E I / rho A) / (2 pi L^2).

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        density: rho [kg/m^3].
        count: how many.
        supports: two of "clamped", "pinned", "sliding", "free" with a hyphen.
        direction: "y" or "z", the axis along which the beam deflects.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: a length, support, direction or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko, Vibration Problems in Engineering, lateral vibration of prismatic bars.
    """
    span = require_positive("length", length, unit="m")
    stiffness = require_modulus("young", young, unit="Pa") * second_moment(section, direction)
    mass = require_modulus("density", density, unit="kg/m^3") * section.area
    roots = bending_roots(count, supports=supports)
    return (roots / span) ** 2 * np.sqrt(stiffness / mass) / (2.0 * np.pi)


def timoshenko_frequencies(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    density: float,
    count: int,
    supports: str = "clamped-free",
    direction: str = "z",
    shear: str | float = "cowper",
) -> Array:
    """Bending frequencies of Timoshenko's beam: shear flexibility and rotary inertia included.

    Exact, by counting (see `dynamic_stiffness`): all frequencies are there, also those above the
    cut-off sqrt(kappa G A / rho I), where the second spectrum mixes in. There Timoshenko's theory
    itself stops being a good model of a solid.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].
        count: how many.
        supports: two of "clamped", "pinned", "sliding", "free" with a hyphen.
        direction: "y" or "z", the axis along which the beam deflects.
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-].

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: a length, support, direction, shear rule or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko, Phil. Mag. 41 (1921) 744 and 43 (1922) 125; Huang, J. Appl. Mech. 28 (1961) 579;
        Han, Benaroya and Wei, J. Sound Vib. 225 (1999) 935.
    """
    segment = Segment(length=length, section=section, young=young, poisson=poisson, density=density)
    piece = beam_piece(segment, direction=direction, theory="timoshenko", shear=shear)
    return natural_frequencies([piece], beam_supports(supports), count=require_count(count))


def axial_frequencies(
    *, length: float, young: float, density: float, count: int, ends: str = "fixed-free"
) -> Array:
    """Longitudinal frequencies of a slender uniform bar, x sqrt(E / rho) / (2 pi L).

    x = (n - 1/2) pi if one end is fixed, n pi if both or none are. Lateral inertia is neglected:
    the shortest wave must be long against the section.

    Args:
        length: L [m].
        young: E [Pa].
        density: rho [kg/m^3].
        count: how many.
        ends: two of "fixed", "free" with a hyphen.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: a length, end or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Rayleigh, The Theory of Sound, vol. 1, chapter VII.
    """
    speed = np.sqrt(
        require_modulus("young", young, unit="Pa")
        / require_modulus("density", density, unit="kg/m^3")
    )
    span = require_positive("length", length, unit="m")
    return bar_roots(count, ends=ends) * speed / (2.0 * np.pi * span)


def torsional_frequencies(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    density: float,
    count: int,
    ends: str = "fixed-free",
) -> Array:
    """Torsional frequencies of a uniform bar, x sqrt(G J / rho I_p) / (2 pi L).

    x as in `axial_frequencies`. St. Venant torsion: warping is free and its inertia neglected,
    exact for round sections; a clamp that stops the warping of a rectangle stiffens it a little.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].
        count: how many.
        ends: two of "fixed", "free" with a hyphen.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: a length, end or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Timoshenko, Vibration Problems in Engineering, torsional vibration of shafts.
    """
    stiffness = shear_modulus(young, poisson) * section.torsion_constant
    inertia = require_modulus("density", density, unit="kg/m^3") * section.polar_moment
    span = require_positive("length", length, unit="m")
    return bar_roots(count, ends=ends) * np.sqrt(stiffness / inertia) / (2.0 * np.pi * span)
