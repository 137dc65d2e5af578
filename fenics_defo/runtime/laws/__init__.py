"""Laws evaluated by NumPy alone, for many points at once."""

from fenics_defo.runtime.laws.corotational import corotational
from fenics_defo.runtime.laws.invertible import invertible
from fenics_defo.runtime.laws.kernel import PointKernel
from fenics_defo.runtime.laws.material_law import MaterialLaw
from fenics_defo.runtime.laws.polar import polar_rotation
from fenics_defo.runtime.laws.response import PointResponse
from fenics_defo.runtime.laws.springs import Springs, cell_springs
from fenics_defo.runtime.laws.svd3 import signed_svd

__all__ = [
    "MaterialLaw",
    "PointKernel",
    "PointResponse",
    "Springs",
    "cell_springs",
    "corotational",
    "invertible",
    "polar_rotation",
    "signed_svd",
]
