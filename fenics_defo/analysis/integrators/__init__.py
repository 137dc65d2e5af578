"""Methods that carry a body's motion from one time to the next, each in a file of its own."""

from fenics_defo.analysis.integrators.backward_euler import BackwardEuler
from fenics_defo.analysis.integrators.central_differences import CentralDifferences
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.integrators.newmark import ImplicitNewmark
from fenics_defo.analysis.integrators.quasi_static import QuasiStatic
from fenics_defo.analysis.integrators.symplectic_euler import SymplecticEuler

__all__ = [
    "BackwardEuler",
    "CentralDifferences",
    "ImplicitNewmark",
    "Integrator",
    "QuasiStatic",
    "SymplecticEuler",
]
