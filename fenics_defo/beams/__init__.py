"""Closed-form references for users' own tests: beams, the elastica, the sphere, finite strain.

Everything is in SI units, takes keyword arguments and returns NumPy arrays or frozen records.
Needs NumPy and SciPy only.
"""

from fenics_defo.beams.cantilever import (
    CantileverSpectrum,
    cantilever_frequencies,
    cantilever_spectrum,
)
from fenics_defo.beams.checks import BeamError
from fenics_defo.beams.elastica import TipPose, elastica_end_force, elastica_end_moment
from fenics_defo.beams.homogeneous import (
    LimitPoint,
    StretchedState,
    compressive_limit,
    equibiaxial_tension,
    principal_stresses,
    simple_shear,
    uniaxial_tension,
)
from fenics_defo.beams.oscillator import DampedOscillator, rayleigh_oscillator
from fenics_defo.beams.roots import bar_roots, bending_roots
from fenics_defo.beams.sections import CircularSection, RectangularSection, Section, TubeSection
from fenics_defo.beams.sphere import SphereModes, sphere_frequencies
from fenics_defo.beams.statics import (
    TipDeflection,
    axial_elongation,
    buckling_load,
    cantilever_tip,
    midspan_deflection,
    twist_angle,
)
from fenics_defo.beams.stepped import (
    Segment,
    stepped_axial_frequencies,
    stepped_bending_frequencies,
    stepped_torsional_frequencies,
)
from fenics_defo.beams.vibration import (
    axial_frequencies,
    euler_bernoulli_frequencies,
    timoshenko_frequencies,
    torsional_frequencies,
)

__all__ = [
    "BeamError",
    "CantileverSpectrum",
    "CircularSection",
    "DampedOscillator",
    "LimitPoint",
    "RectangularSection",
    "Section",
    "Segment",
    "SphereModes",
    "StretchedState",
    "TipDeflection",
    "TipPose",
    "TubeSection",
    "axial_elongation",
    "axial_frequencies",
    "bar_roots",
    "bending_roots",
    "buckling_load",
    "cantilever_frequencies",
    "cantilever_spectrum",
    "cantilever_tip",
    "compressive_limit",
    "elastica_end_force",
    "elastica_end_moment",
    "equibiaxial_tension",
    "euler_bernoulli_frequencies",
    "midspan_deflection",
    "principal_stresses",
    "rayleigh_oscillator",
    "simple_shear",
    "sphere_frequencies",
    "stepped_axial_frequencies",
    "stepped_bending_frequencies",
    "stepped_torsional_frequencies",
    "timoshenko_frequencies",
    "torsional_frequencies",
    "twist_angle",
    "uniaxial_tension",
]
