"""Forces on parts of the surface: tractions that keep their direction, pressure that follows."""

from functools import cached_property

from petsc4py import PETSc

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.energy import deformation_gradient
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.jit import compiled
from fenics_defo.fem.regions import select_facets
from fenics_defo.fem.solid import Solid

Array = NDArray[np.float64]

# Exact for pressure in any deformed state, whose normals are products of two tangents; order of the
# displacements or of the geometry, whichever is higher.
_DEGREE = {
    ("tetrahedron", 1): 1,
    ("tetrahedron", 2): 4,
    ("hexahedron", 1): 3,
    ("hexahedron", 2): 5,
}


def _surface(solid: Solid, region: str | int) -> ufl.Measure:
    mesh = solid.space.mesh
    facets = select_facets(solid.mesh_data, region)
    tags = dolfinx.mesh.meshtags(mesh, 2, facets, np.ones(len(facets), np.int32))
    order = max(solid.order, mesh.geometry.cmaps[0].degree)
    degree = _DEGREE[mesh.topology.cell_name(), order]
    ds = ufl.Measure("ds", mesh, subdomain_data=tags, metadata={"quadrature_degree": degree})
    return ds(1)


def surface_weights(solid: Solid, region: str | int) -> Array:
    """∫ Nᵢ dA over facets of the surface at rest: times a traction [Pa], the nodes' forces [N].

    Collective.

    Args:
        solid: body.
        region: selection of facets.

    Returns:
        (owned nodes,) [m²]; their sum over all ranks is the area.

    Raises:
        SelectionError: nothing of the surface is selected.
    """
    form = compiled(ufl.TestFunction(solid.space)[0] * _surface(solid, region))
    vector = dolfinx.fem.assemble_vector(form)
    vector.scatter_reverse(dolfinx.la.InsertMode.add)
    return np.array(vector.array.reshape(-1, 3)[: solid.nodes.owned, 0])


class PressureForm:
    """A pressure p that follows the surface: forces -p ∫ J F⁻ᵀ N Nᵢ dA, over facets at rest.

    J F⁻ᵀ N dA is the deformed area times its normal (Nanson). All methods are collective.

    Args:
        solid: body.
        region: selection of facets.

    Raises:
        SelectionError: nothing of the surface is selected.
    """

    def __init__(self, solid: Solid, region: str | int) -> None:
        self._assembly, space = solid.assembly, solid.space
        self._displacement = dolfinx.fem.Function(space)
        self._pressure = dolfinx.fem.Constant(space.mesh, 0.0)
        normal = ufl.cofac(deformation_gradient(self._displacement)) * ufl.FacetNormal(space.mesh)
        work = -self._pressure * ufl.inner(normal, ufl.TestFunction(space))
        self._form = work * _surface(solid, region)

    @cached_property
    def _force(self) -> "dolfinx.fem.Form":
        return compiled(self._form)

    @cached_property
    def _derivative(self) -> ufl.Form:
        trial = ufl.TrialFunction(self._displacement.function_space)
        return ufl.derivative(self._form, self._displacement, trial)

    @cached_property
    def _tangent(self) -> "dolfinx.fem.Form":
        return compiled(self._derivative)

    @cached_property
    def _symmetric_tangent(self) -> "dolfinx.fem.Form":
        half = 0.5 * self._derivative
        return compiled(half + ufl.adjoint(half))

    def _deform(self, local: Array, pressure: float) -> None:
        self._displacement.x.array[:] = local.ravel()
        self._pressure.value = pressure

    def force(self, local: Array, pressure: float) -> Array:
        """Forces of the nodes (d, 3) [N], complete at owned ones.

        Args:
            local: displacement (d, 3) [m].
            pressure: [Pa], positive where it pushes inwards.
        """
        self._deform(local, pressure)
        vector = dolfinx.fem.assemble_vector(self._force)
        vector.scatter_reverse(dolfinx.la.InsertMode.add)
        return np.array(vector.array.reshape(-1, 3))

    def add_tangent(
        self, matrix: PETSc.Mat, local: Array, pressure: float, *, symmetric: bool = True
    ) -> None:
        """Add the derivative of `force` by the displacement; rows of held components stay.

        A stiffness has it with a minus sign: give the negative pressure.

        Args:
            matrix: from `Assembly.empty_matrix` of the body.
            local: displacement (d, 3) [m].
            pressure: [Pa].
            symmetric: its symmetric part only, which is all of it where the surface is closed or
                its rim is held: the linear solvers are those of symmetric matrices.
        """
        self._deform(local, pressure)
        form = self._symmetric_tangent if symmetric else self._tangent
        self._assembly.add_form(matrix, form)
