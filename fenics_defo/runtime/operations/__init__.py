"""Lists of array operations as data: what a material law is in a model file. NumPy only."""

from fenics_defo.runtime.operations.catalogue import OPERATIONS
from fenics_defo.runtime.operations.listing import OperationList
from fenics_defo.runtime.operations.machine import Machine, evaluate

__all__ = ["OPERATIONS", "Machine", "OperationList", "evaluate"]
