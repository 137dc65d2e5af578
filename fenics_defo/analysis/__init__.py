"""Computations on bodies: vibration modes."""

from fenics_defo.analysis.motion import describe_motion
from fenics_defo.analysis.phases import Phases

__all__ = ["Phases", "describe_motion"]
