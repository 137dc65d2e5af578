"""Everything that a body can be made of."""

from fenics_defo.energy.mass_spring import MassSpring
from fenics_defo.energy.material import Material
from fenics_defo.energy.point_law import PointLaw

#: An energy in UFL, a law evaluated at points, or springs.
type Law = Material | PointLaw | MassSpring
