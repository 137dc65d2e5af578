"""Variational forms of a hyperelastic body: energy, internal force, tangent and mass."""

from dataclasses import dataclass

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.core.expr import Expr

from fenics_defo.energy import Material, deformation_gradient, tangent
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.material_fields import LawRegion, MaterialFields

# Exact for St. Venant-Kirchhoff on cells with straight edges: the energy has four factors grad u.
_ENERGY_DEGREE = {
    ("tetrahedron", 1): 1,
    ("tetrahedron", 2): 4,
    ("hexahedron", 1): 3,
    ("hexahedron", 2): 5,
}
# Exact on affine cells for two factors grad u, and for two factors u.
_REST_DEGREE = {
    ("tetrahedron", 1): 1,
    ("tetrahedron", 2): 2,
    ("hexahedron", 1): 3,
    ("hexahedron", 2): 5,
}
_MASS_DEGREE = {
    ("tetrahedron", 1): 2,
    ("tetrahedron", 2): 4,
    ("hexahedron", 1): 3,
    ("hexahedron", 2): 5,
}


@dataclass(frozen=True, slots=True)
class QuadratureDegrees:
    """Polynomial degrees that the quadrature rules integrate exactly.

    Args:
        energy: of energy, force and tangent in a deformed configuration.
        rest: of the stiffness at rest.
        mass: of the mass matrix.
    """

    energy: int
    rest: int
    mass: int


def default_degrees(kind: str, order: int, mesh_order: int) -> QuadratureDegrees:
    """Degrees for a cell kind, the order of the displacements and that of the geometry.

    They integrate St. Venant-Kirchhoff's energy and the masses exactly on tetrahedra with straight
    edges; on hexahedra they are the usual Gauss rules of order + 1 points a direction. Curved cells
    get a higher rule.
    """
    key = (kind, max(order, mesh_order))
    curved = mesh_order > 1
    return QuadratureDegrees(
        energy=_ENERGY_DEGREE[key],
        rest=_ENERGY_DEGREE[key] if curved else _REST_DEGREE[kind, order],
        mass=_MASS_DEGREE[key] + (1 if curved and kind == "tetrahedron" else 0),
    )


@dataclass(frozen=True)
class EnergyForms:
    """Symbolic forms of the laws that have a UFL energy.

    Args:
        displacement: the function u at which all are taken.
        energy: ∫ ψ(F(u)) dX [J].
        force: its derivative, the internal force f(u) [N].
        tangents: each law's cells and ∂²ψ/∂F² (3, 3, 3, 3) [Pa], from which K(u) comes.
        degree: that all quadrature integrates exactly.
    """

    displacement: "dolfinx.fem.Function"
    energy: ufl.Form
    force: ufl.Form
    tangents: tuple[tuple[NDArray[np.int32], Expr], ...]
    degree: int


@dataclass(frozen=True)
class BodyForms:
    """Symbolic forms of a body on one displacement space.

    Args:
        strain: those of all laws with a UFL energy; None without any.
        rest_tangent: K(0) of these and of the point laws that have moduli at rest, written with the
            laws' moduli at rest where they are isotropic there; None without any.
        mass: ∫ ρ u v dX on scalar functions, the consistent mass of each component [kg].
    """

    strain: EnergyForms | None
    rest_tangent: ufl.Form | None
    mass: ufl.Form


def body_forms(
    space: "dolfinx.fem.FunctionSpace", fields: MaterialFields, degrees: QuadratureDegrees
) -> BodyForms:
    """Write the forms of a body.

    Args:
        space: vector-valued displacement space.
        fields: its materials.
        degrees: quadrature degrees.

    Returns:
        the symbolic forms; nothing is compiled yet.
    """
    trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
    parts = _measures(space.mesh, fields.regions)
    rest = [
        _rest_tangent(region, part(degree=degrees.rest), trial, test)
        if region.rest_moduli is not None
        else _at_zero(region, part(degree=degrees.energy), space, trial, test)
        for region, part in parts
        if region.rest_moduli is not None or isinstance(region.material, Material)
    ]
    scalar = _scalar_space(space)
    dx = ufl.Measure("dx", space.mesh, metadata={"quadrature_degree": degrees.mass})
    return BodyForms(
        strain=_energy_forms(space, parts, degrees.energy),
        rest_tangent=sum(rest) if rest else None,
        mass=fields.density * ufl.TrialFunction(scalar) * ufl.TestFunction(scalar) * dx,
    )


def _energy_forms(
    space: "dolfinx.fem.FunctionSpace", parts: list[tuple[LawRegion, ufl.Measure]], degree: int
) -> EnergyForms | None:
    u = dolfinx.fem.Function(space, name="displacement")
    F = ufl.variable(deformation_gradient(u))
    mine = [
        (region, region.material, part)
        for region, part in parts
        if isinstance(region.material, Material)
    ]
    if not mine:
        return None
    # Not the variable F: strains can be written without taking I from I + ∇u again.
    plain = ufl.Identity(3) + ufl.grad(u)
    energy = sum(
        material.strain_energy(plain, region.parameters) * part(degree=degree)
        for region, material, part in mine
    )
    return EnergyForms(
        displacement=u,
        energy=energy,
        force=ufl.derivative(energy, u, ufl.TestFunction(space)),
        tangents=tuple(
            (region.cells, tangent(material, F, parameters=region.parameters))
            for region, material, _ in mine
        ),
        degree=degree,
    )


def _scalar_space(space: "dolfinx.fem.FunctionSpace") -> "dolfinx.fem.FunctionSpace":
    """Scalar functions on the nodes of a vector space, numbered alike."""
    scalar = dolfinx.fem.functionspace(space.mesh, ("Lagrange", space.element.basix_element.degree))
    if not np.array_equal(scalar.dofmap.list, space.dofmap.list):
        raise RuntimeError("DOLFINx numbers the nodes of scalar and vector functions differently")
    return scalar


def _measures(
    mesh: "dolfinx.mesh.Mesh", regions: tuple[LawRegion, ...]
) -> list[tuple[LawRegion, ufl.Measure]]:
    if len(regions) == 1:
        return [(regions[0], ufl.Measure("dx", mesh))]
    cells = np.concatenate([region.cells for region in regions])
    laws = np.concatenate([np.full(len(r.cells), i, np.int32) for i, r in enumerate(regions)])
    order = np.argsort(cells)
    tags = dolfinx.mesh.meshtags(mesh, 3, cells[order], laws[order])
    dx = ufl.Measure("dx", mesh, subdomain_data=tags)
    return [(region, dx(law)) for law, region in enumerate(regions)]


def _rest_tangent(
    region: LawRegion, dx: ufl.Measure, trial: ufl.Argument, test: ufl.Argument
) -> ufl.Form:
    """Hooke's law with the moduli at rest: λ div u div v + 2 μ ε(u) : ε(v)."""
    assert region.rest_moduli is not None
    lmbda, mu = region.rest_moduli
    strain = ufl.sym(ufl.grad(trial))
    return (
        lmbda * ufl.div(trial) * ufl.div(test)
        + 2.0 * mu * ufl.inner(strain, ufl.sym(ufl.grad(test)))
    ) * dx


def _at_zero(
    region: LawRegion,
    dx: ufl.Measure,
    space: "dolfinx.fem.FunctionSpace",
    trial: ufl.Argument,
    test: ufl.Argument,
) -> ufl.Form:
    """The law's own tangent about a displacement that stays zero."""
    assert isinstance(region.material, Material)
    zero = dolfinx.fem.Function(space)
    psi = region.material.strain_energy(deformation_gradient(zero), region.parameters) * dx
    return ufl.derivative(ufl.derivative(psi, zero, test), zero, trial)
