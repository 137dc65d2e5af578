"""Hyperelastic energies as UFL functions of the deformation gradient, and their constants."""

from fenics_defo.energy.constants import Constant
from fenics_defo.energy.corotational import Corotational
from fenics_defo.energy.evaluation import evaluate
from fenics_defo.energy.formula import formula
from fenics_defo.energy.invertible import Invertible
from fenics_defo.energy.kinematics import (
    deformation_gradient,
    green_lagrange,
    invariants,
    isochoric_invariants,
    right_cauchy_green,
    small_strain,
)
from fenics_defo.energy.law import Law
from fenics_defo.energy.mass_spring import MassSpring
from fenics_defo.energy.material import IsotropicMaterial, Material, cell_count
from fenics_defo.energy.material_laws import material_law
from fenics_defo.energy.materials import LinearElastic, MooneyRivlin, NeoHookean, StVenantKirchhoff
from fenics_defo.energy.point_law import PointLaw
from fenics_defo.energy.rest_state import RestState, linear_moduli, rest_state
from fenics_defo.energy.stress import cauchy, first_piola, second_piola, tangent
from fenics_defo.energy.tables import material_from_table, read_materials
from fenics_defo.energy.ufl_caches import forget_traversals
from fenics_defo.energy.user_energy import HyperelasticEnergy, IsotropicEnergy
from fenics_defo.runtime.laws import PointResponse

__all__ = [
    "Constant",
    "Corotational",
    "HyperelasticEnergy",
    "Invertible",
    "IsotropicEnergy",
    "IsotropicMaterial",
    "Law",
    "LinearElastic",
    "MassSpring",
    "Material",
    "MooneyRivlin",
    "NeoHookean",
    "PointLaw",
    "PointResponse",
    "RestState",
    "StVenantKirchhoff",
    "cauchy",
    "cell_count",
    "deformation_gradient",
    "evaluate",
    "first_piola",
    "formula",
    "green_lagrange",
    "invariants",
    "isochoric_invariants",
    "linear_moduli",
    "material_from_table",
    "material_law",
    "read_materials",
    "rest_state",
    "right_cauchy_green",
    "second_piola",
    "small_strain",
    "tangent",
]

forget_traversals()
