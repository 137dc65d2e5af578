"""Methods that carry a reduced model's motion on, each in a file of its own."""

from fenics_defo.runtime.integrators.backward_euler import BackwardEuler
from fenics_defo.runtime.integrators.central_differences import CentralDifferences
from fenics_defo.runtime.integrators.energies import Energies
from fenics_defo.runtime.integrators.modal_filter import ModalFilter
from fenics_defo.runtime.integrators.newmark import ImplicitNewmark
from fenics_defo.runtime.integrators.stepper import Stepper
from fenics_defo.runtime.integrators.symplectic_euler import SymplecticEuler

__all__ = [
    "BackwardEuler",
    "CentralDifferences",
    "Energies",
    "ImplicitNewmark",
    "ModalFilter",
    "Stepper",
    "SymplecticEuler",
]
