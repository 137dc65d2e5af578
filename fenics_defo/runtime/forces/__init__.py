"""Reduced internal forces: what a model knows of its material."""

from fenics_defo.runtime.forces.cubic import CubicForce, TaylorForce
from fenics_defo.runtime.forces.force_law import Evaluator, ForceLaw
from fenics_defo.runtime.forces.linear import LinearForce

__all__ = ["CubicForce", "Evaluator", "ForceLaw", "LinearForce", "TaylorForce"]
