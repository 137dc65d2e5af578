"""Beams and bars of several uniform segments joined end to end: steps and two-material solids.

The segments' centroids lie on one line and their principal axes are parallel. One-dimensional
theory ignores the disturbance of the stress close to a step: it is good when the segments are long
against their depth.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.beams.checks import (
    BeamError,
    require_choice,
    require_count,
    require_modulus,
    require_poisson,
    require_positive,
    shear_modulus,
)
from fenics_defo.beams.dynamic_stiffness import natural_frequencies
from fenics_defo.beams.pieces import BarPiece, BeamPiece
from fenics_defo.beams.sections import Section, resolve_shear_coefficient, second_moment
from fenics_defo.beams.supports import bar_supports, beam_supports

type Array = NDArray[np.float64]

BEAM_THEORIES = ("euler-bernoulli", "timoshenko")


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """Uniform part of a beam or bar.

    Args:
        length: [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].

    Raises:
        BeamError: the length is not positive and finite.
        MaterialError: a material constant is out of range.
    """

    length: float
    section: Section
    young: float
    poisson: float
    density: float

    def __post_init__(self) -> None:
        require_positive("length", self.length, unit="m")
        require_modulus("young", self.young, unit="Pa")
        require_poisson(self.poisson)
        require_modulus("density", self.density, unit="kg/m^3")


def stepped_bending_frequencies(
    segments: Sequence[Segment],
    *,
    count: int,
    supports: str = "clamped-free",
    direction: str = "z",
    theory: str = "timoshenko",
    shear: str | float = "cowper",
) -> Array:
    """Bending frequencies of segments joined end to end, exact within beam theory.

    Deflection, rotation, moment and shear force are continuous at the joints; every frequency is
    found (Wittrick and Williams's count, see `dynamic_stiffness`).

    Args:
        segments: in order along the axis; the first support word is for the first one's end.
        count: how many.
        supports: two of "clamped", "pinned", "sliding", "free" with a hyphen.
        direction: "y" or "z", the axis along which the beam deflects.
        theory: "euler-bernoulli" or "timoshenko".
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-] for all segments.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: no segments, or a support, direction, theory, shear rule or count is not allowed.

    References:
        Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263; Howson and Williams, J. Sound
        Vib. 26 (1973) 503, for Timoshenko members.
    """
    pieces = [
        beam_piece(segment, direction=direction, theory=theory, shear=shear)
        for segment in _checked(segments)
    ]
    return natural_frequencies(pieces, beam_supports(supports), count=require_count(count))


def stepped_axial_frequencies(
    segments: Sequence[Segment], *, count: int, ends: str = "fixed-free"
) -> Array:
    """Longitudinal frequencies of segments joined end to end, exact within bar theory.

    Displacement and force E A u' are continuous at the joints.

    Args:
        segments: in order along the axis; the first word of ``ends`` is for the first one.
        count: how many.
        ends: two of "fixed", "free" with a hyphen.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: no segments, or unknown ends or a count below 1.

    References:
        Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263.
    """
    pieces = [
        BarPiece(s.length, s.young * s.section.area, s.density * s.section.area)
        for s in _checked(segments)
    ]
    return natural_frequencies(pieces, bar_supports(ends), count=require_count(count))


def stepped_torsional_frequencies(
    segments: Sequence[Segment], *, count: int, ends: str = "fixed-free"
) -> Array:
    """Torsional frequencies of segments joined end to end, with St. Venant's stiffness.

    Twist and torque G J theta' are continuous at the joints.

    Args:
        segments: in order along the axis; the first word of ``ends`` is for the first one.
        count: how many.
        ends: two of "fixed", "free" with a hyphen.

    Returns:
        Frequencies [Hz], (count,), ascending, elastic ones only.

    Raises:
        BeamError: no segments, or unknown ends or a count below 1.

    References:
        Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263.
    """
    pieces = [
        BarPiece(
            s.length,
            shear_modulus(s.young, s.poisson) * s.section.torsion_constant,
            s.density * s.section.polar_moment,
        )
        for s in _checked(segments)
    ]
    return natural_frequencies(pieces, bar_supports(ends), count=require_count(count))


def beam_piece(segment: Segment, *, direction: str, theory: str, shear: str | float) -> BeamPiece:
    """The constants of one segment's bending, shear and rotary terms left out if slender.

    Raises:
        BeamError: the direction, theory or shear rule is not allowed.
    """
    moment = second_moment(segment.section, direction)
    stiffness, mass = segment.young * moment, segment.density * segment.section.area
    if require_choice("theory", theory, BEAM_THEORIES) == "euler-bernoulli":
        return BeamPiece(segment.length, stiffness, mass)
    kappa = resolve_shear_coefficient(segment.section, segment.poisson, shear)
    rigidity = kappa * shear_modulus(segment.young, segment.poisson) * segment.section.area
    return BeamPiece(segment.length, stiffness, mass, 1.0 / rigidity, segment.density * moment)


def _checked(segments: Sequence[Segment]) -> Sequence[Segment]:
    if len(segments) == 0:
        raise BeamError("segments must hold at least one Segment, got none")
    return segments
