"""Reduced internal forces: what a model knows of its material."""

from fenics_defo.runtime.forces.cubature import CubatureForce
from fenics_defo.runtime.forces.cubic import CubicForce, TaylorForce
from fenics_defo.runtime.forces.force_law import Evaluator, ForceLaw, StoredLaw
from fenics_defo.runtime.forces.linear import LinearForce

__all__ = [
    "CubatureForce",
    "CubicForce",
    "Evaluator",
    "ForceLaw",
    "LinearForce",
    "StoredLaw",
    "TaylorForce",
]
