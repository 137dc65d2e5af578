"""Forces on parts of the surface."""

from petsc4py import PETSc

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.energy import deformation_gradient
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.regions import select_entities

Array = NDArray[np.float64]


def _measure(solid: Solid, region: str | int) -> ufl.Measure:
    mesh = solid.mesh_data.mesh
    facets = select_entities(solid.mesh_data, region, dimension=2)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), np.int32))
    degree = 2 * solid.order + (2 if solid.nodes.cell_type.startswith("hexa") else 0)
    return ufl.Measure("ds", mesh, subdomain_data=tags, metadata={"quadrature_degree": degree})(1)


def surface_weights(solid: Solid, region: str | int) -> Array:
    """∫ Nᵢ dA over boundary facets at rest (owned nodes,) [m²]; collective."""
    test = ufl.TestFunction(solid.space)
    form = dolfinx.fem.form(test[0] * _measure(solid, region))
    vector = dolfinx.fem.assemble_vector(form)
    vector.scatter_reverse(dolfinx.la.InsertMode.add)
    return np.array(vector.array.reshape(-1, 3)[: solid.nodes.owned, 0])


class PressureForm:
    """A unit pressure that follows the surface: -∫ J F⁻ᵀ N · v dA; collective.

    Args:
        solid: body.
        region: selection of boundary facets.
    """

    def __init__(self, solid: Solid, region: str | int) -> None:
        space = solid.space
        self._assembly = solid.assembly
        self._displacement = dolfinx.fem.Function(space)
        self._pressure = dolfinx.fem.Constant(space.mesh, 0.0)
        F = deformation_gradient(self._displacement)
        normal = ufl.cofac(F) * ufl.FacetNormal(space.mesh)
        force = -self._pressure * ufl.inner(normal, ufl.TestFunction(space))
        measure = _measure(solid, region)
        self._force = dolfinx.fem.form(force * measure)
        tangent = ufl.derivative(
            0.5 * force * measure, self._displacement, ufl.TrialFunction(space)
        )
        # Only on a closed or supported surface has the pressure a potential and this is symmetric;
        # the solvers want its symmetric part in any case, and Newton's method forgives the rest.
        self._tangent = dolfinx.fem.form(tangent + ufl.adjoint(tangent))

    def _deform(self, local: Array, pressure: float) -> None:
        self._displacement.x.array[:] = local.ravel()
        self._pressure.value = pressure

    def force(self, local: Array, pressure: float) -> Array:
        """Nodal forces (d, 3) [N], complete at owned nodes."""
        self._deform(local, pressure)
        vector = dolfinx.fem.assemble_vector(self._force)
        vector.scatter_reverse(dolfinx.la.InsertMode.add)
        return np.array(vector.array.reshape(-1, 3))

    def add_tangent(
        self, matrix: PETSc.Mat, local: Array, pressure: float, *, diagonal: float
    ) -> None:
        """Add the symmetric part of the forces' derivative [N/m] to a matrix.

        Args:
            matrix: from `Assembly.empty_matrix`, filled.
            local: displacement (d, 3) [m] of this rank's nodes.
            pressure: [Pa].
            diagonal: entry of the held rows, which stay as they are otherwise.
        """
        self._deform(local, pressure)
        dolfinx.fem.petsc.assemble_matrix(
            matrix, self._tangent, bcs=self._assembly.constraints, diag=diagonal
        )
        matrix.assemble()
