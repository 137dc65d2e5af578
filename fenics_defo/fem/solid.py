"""A deformable body: mesh, materials and constraints, with its energy, forces and matrices."""

from collections.abc import Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fenics_defo.energy import LinearElastic
from fenics_defo.errors import DefoError, MeshError, SelectionError
from fenics_defo.fem.assembly import Assembly
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.forms import QuadratureDegrees, body_forms, default_degrees
from fenics_defo.fem.imported import MeshData, MeshRecord, mesh_record
from fenics_defo.fem.material_fields import MaterialFields, Materials, lay_materials
from fenics_defo.fem.nodes import NodeNumbering, number_nodes
from fenics_defo.fem.parts import body_parts
from fenics_defo.fem.regions import select_nodes

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Fixed:
    """A constraint: the named displacement components are zero at the selected nodes.

    Args:
        region: selection (group name or number, comparison, ``nodes:FILE``).
        components: some of "xyz", as text or as a list of letters.

    Raises:
        SelectionError: ``components`` is empty or names something else.
    """

    region: str | int
    components: str = "xyz"

    def __post_init__(self) -> None:
        if not isinstance(self.components, str | list | tuple) or (
            not self.components or not all(c in ("x", "y", "z") for c in self.components)
        ):
            raise SelectionError(
                f"the components of a constraint must be some of 'x', 'y', 'z', got "
                f"{self.components!r}; write 'xyz' to hold a region altogether"
            )


class Solid:
    """A hyperelastic body on a mesh, held at selected nodes, in any deformed configuration.

    Displacements, forces and masses go in and out as arrays over the nodes in the order of the
    user's file (then the nodes that order 2 appends). Each form is compiled on first use and kept.
    All methods are collective on the mesh's communicator, take the same arrays on each rank and
    give the same numbers there.

    Args:
        mesh_data: what ``read_mesh``, ``build_mesh`` or DOLFINx's gmsh reader returned.
        material: one material, or a mapping of regions to materials (None: all other cells).
        order: polynomial order of the displacements, 1 or 2.
        fixed: selections held in all components, or `Fixed` records.
        degrees: quadrature degrees; those of ``fem.forms.default_degrees`` if not given.

    Raises:
        MeshError: the mesh is not made of tetrahedra or hexahedra in space.
        MaterialError: the material does not cover the mesh.
        SelectionError: a constraint matches nothing.
        DefoError: ``order`` is not 1 or 2.
    """

    def __init__(
        self,
        mesh_data: MeshData,
        material: Materials,
        *,
        order: int = 1,
        fixed: Sequence[str | int | Fixed] = (),
        degrees: QuadratureDegrees | None = None,
    ) -> None:
        if not isinstance(mesh_data, MeshData):
            raise MeshError(
                f"a body needs what read_mesh or build_mesh returned, got {mesh_data!r}; "
                "read the file first: fem.Solid(fem.read_mesh(path), material)"
            )
        mesh = mesh_data.mesh
        kind = mesh.topology.cell_name()
        if kind not in ("tetrahedron", "hexahedron") or mesh.geometry.cmaps[0].degree > 2:
            raise MeshError(
                f"a body needs tetrahedra or hexahedra of order 1 or 2, got {kind} cells of order "
                f"{mesh.geometry.cmaps[0].degree}"
            )
        if order not in (1, 2):
            raise DefoError(f"order must be 1 or 2, got {order!r}")
        constraints = [fixed] if isinstance(fixed, str | int | Fixed) else list(fixed)
        self.mesh_data = mesh_data
        self.record: MeshRecord = mesh_record(mesh_data)
        self.order = order
        self.materials = material
        self.space = dolfinx.fem.functionspace(mesh, ("Lagrange", order, (3,)))
        self.nodes: NodeNumbering = number_nodes(self.space, mesh.topology.index_map(3).size_global)
        self.held: NDArray[np.bool_] = self._held(constraints)
        #: The laws laid over the cells, and the degrees of their quadrature: for offline stages.
        self.fields: MaterialFields = lay_materials(mesh_data, material)
        fields = self.fields
        #: Whether all laws are isotropic and free of stress at rest.
        self.is_isotropic_at_rest = all(region.rest_moduli for region in fields.regions)
        #: Whether the internal force is linear in the displacement, the tangent one and the same.
        self.is_linear = all(isinstance(r.material, LinearElastic) for r in fields.regions)
        self.degrees = degrees or default_degrees(kind, order, mesh.geometry.cmaps[0].degree)
        forms = body_forms(self.space, fields, self.degrees)
        parts, unformed = body_parts(self.space, forms, fields, self.degrees.energy)
        #: Energy, force and PETSc matrices, for ``fem`` and ``analysis`` only.
        self.assembly = Assembly(self.space, forms, parts, unformed, self.nodes.scatter(self.held))

    def _held(self, fixed: Sequence[str | int | Fixed]) -> NDArray[np.bool_]:
        held = np.zeros((self.nodes.size, 3), bool)
        for item in fixed:
            constraint = item if isinstance(item, Fixed) else Fixed(item)
            chosen = select_nodes(self.mesh_data, self.space, self.nodes, constraint.region)
            held[np.ix_(chosen, ["xyz".index(c) for c in constraint.components])] = True
        return held

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the mesh."""
        return self.mesh_data.mesh.comm

    @property
    def points(self) -> Array:
        """Nodes at rest (n, 3) [m]."""
        return self.nodes.points

    @property
    def cells(self) -> NDArray[np.int64]:
        """Rows of ``points`` (m, c), cells in the file's order, nodes in VTK's."""
        return self.nodes.cells

    @property
    def dof_count(self) -> int:
        """Number of displacement components, held ones included."""
        return 3 * int(self.space.dofmap.index_map.size_global)

    def energy(self, displacement: Array | None = None) -> float:
        """Strain energy [J].

        Args:
            displacement: (n, 3) [m]; rest if not given.

        Raises:
            DefoError: wrong shape, or not finite.
        """
        return self.assembly.energy(self._local(displacement))

    def internal_force(self, displacement: Array | None = None) -> Array:
        """Gradient of the energy (n, 3) [N], reactions at held nodes included.

        Args:
            displacement: (n, 3) [m]; rest if not given.

        Raises:
            DefoError: wrong shape, or not finite.
        """
        return self.nodes.gather_own(self.assembly.force(self._local(displacement)))

    def tangent(self, displacement: Array | None = None) -> sparse.csr_array:
        """Derivative of the internal force (3n, 3n) [N/m], without constraints.

        Row 3 i + c belongs to component c of node i.

        Args:
            displacement: (n, 3) [m]; rest if not given.

        Raises:
            DefoError: wrong shape, or not finite.
        """
        local = None if displacement is None else self._local(displacement)
        return self._gather_matrix(self.assembly.unconstrained_tangent(local))

    def mass(self) -> sparse.csr_array:
        """Consistent mass matrix (3n, 3n) [kg], without constraints, rows as in `tangent`."""
        return self._gather_matrix(self.assembly.mass.entries())

    def lumped_mass(self) -> Array:
        """Mass of each node (n,) [kg]: the consistent mass's diagonal, scaled to the body's mass.

        Hinton, Rock and Zienkiewicz (1976): positive for order 2 too, where row sums are not.
        """
        return self.nodes.gather_own(self.assembly.lumped_mass())

    def total_mass(self) -> float:
        """Mass of the body [kg]."""
        return self.assembly.mass.total()

    def _local(self, displacement: Array | None) -> Array:
        """This rank's part of a displacement; zeros for rest."""
        if displacement is None:
            return np.zeros((len(self.nodes.rows), 3))
        values = np.asarray(displacement, dtype=np.float64)
        if values.shape != (self.nodes.size, 3):
            raise DefoError(
                f"a displacement of this body has the shape ({self.nodes.size}, 3), "
                f"got {values.shape}"
            )
        if not np.isfinite(values).all():
            raise DefoError("a displacement must be finite, got NaN or infinity")
        return self.nodes.scatter(values)

    def _gather_matrix(
        self, entries: tuple[NDArray[np.int64], NDArray[np.int64], Array]
    ) -> sparse.csr_array:
        """All ranks' entries, by the space's global dofs, as one matrix in the user's order."""
        nodes = self.nodes.global_rows
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        rows, columns, values = (
            np.concatenate(parts) for parts in zip(*self.comm.allgather(entries), strict=True)
        )
        size = 3 * self.nodes.size
        return sparse.csr_array((values, (dofs[rows], dofs[columns])), shape=(size, size))
