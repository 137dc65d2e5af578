"""Stresses and the tangent of a material, by UFL's differentiation of its strain energy.

F (3, 3) is the deformation gradient, preferably a ``ufl.variable``; another expression is made one.
``parameters`` holds a UFL scalar for each name of ``material.parameters``. All are UFL expressions.
Source of the relations: Holzapfel, Nonlinear Solid Mechanics (2000), sections 3.4 and 6.1.
"""

from collections.abc import Mapping

import ufl
from ufl.core.expr import Expr

from fenics_defo.energy.material import Material


def first_piola(material: Material, F: Expr, *, parameters: Mapping[str, Expr]) -> Expr:
    """First Piola-Kirchhoff stress P = ∂ψ/∂F (3, 3) [Pa]: force per rest area."""
    F = _variable(F)
    return ufl.diff(material.strain_energy(F, parameters), F)


def tangent(material: Material, F: Expr, *, parameters: Mapping[str, Expr]) -> Expr:
    """First elasticity tensor A = ∂P/∂F (3, 3, 3, 3) [Pa], A_ijkl = ∂P_ij/∂F_kl = A_klij."""
    F = _variable(F)
    return ufl.diff(first_piola(material, F, parameters=parameters), F)


def second_piola(material: Material, F: Expr, *, parameters: Mapping[str, Expr]) -> Expr:
    """Second Piola-Kirchhoff stress S = F⁻¹ P (3, 3) [Pa], symmetric if ψ is objective."""
    return ufl.inv(F) * first_piola(material, F, parameters=parameters)


def cauchy(material: Material, F: Expr, *, parameters: Mapping[str, Expr]) -> Expr:
    """Cauchy stress σ = P Fᵀ/J (3, 3) [Pa], force per deformed area, symmetric if ψ is objective.

    `LinearElastic` is not objective: its σ is symmetric to first order in the displacement only.
    """
    return first_piola(material, F, parameters=parameters) * F.T / ufl.det(F)


def _variable(F: Expr) -> Expr:
    return F if isinstance(F, ufl.classes.Variable) else ufl.variable(F)
