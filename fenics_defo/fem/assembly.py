"""Energy, force and matrices of a body. PETSc's handles stay inside ``fem`` and ``analysis``."""

from functools import cached_property

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.fem.block_matrix import BlockMatrix, HeldBlocks
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.forms import BodyForms
from fenics_defo.fem.jit import compiled
from fenics_defo.fem.mass import ConsistentMass, Entries
from fenics_defo.fem.parts import Part
from fenics_defo.fem.pencil import Pencil
from fenics_defo.fem.tangent_derivative import add_tangent_derivatives
from fenics_defo.fem.ufl_part import add_form

Array = NDArray[np.float64]


class Assembly:
    """Energy, force and matrices of a body over this rank's nodes, owned ones first.

    All are sums over parts: laws of UFL, laws evaluated at points, springs. Each form is compiled
    on its first use. Held components are kept in the stiffness that is meant for solving as unit
    rows, and in the mass as zero rows: their eigenvalues lie at infinity.

    Args:
        space: vector-valued displacement space.
        forms: the body's forms on it.
        parts: what its energy is the sum of.
        unformed: those parts that ``forms.rest_tangent`` lacks.
        held: (d, 3) bool, components that are zero.
    """

    def __init__(
        self,
        space: "dolfinx.fem.FunctionSpace",
        forms: BodyForms,
        parts: tuple[Part, ...],
        unformed: tuple[Part, ...],
        held: NDArray[np.bool_],
    ) -> None:
        self._space = space
        self._forms = forms
        self._parts = parts
        self._unformed = unformed
        self._held = held
        self._present = np.zeros((len(held), 3))

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the mesh."""
        return self._space.mesh.comm

    @property
    def owned(self) -> int:
        """Number of nodes that this rank owns."""
        return self._space.dofmap.index_map.size_local

    @property
    def held(self) -> NDArray[np.bool_]:
        """(d, 3) components that are zero."""
        return self._held

    def with_held(self, held: NDArray[np.bool_]) -> "Assembly":
        """The same body, its compiled forms and its pattern, with other components held.

        Args:
            held: (d, 3) bool, all components that are held, the body's own included.
        """
        other = Assembly(self._space, self._forms, self._parts, self._unformed, held)
        for name in ("_blocks", "_rest_tangent"):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    @cached_property
    def _rest_tangent(self) -> "dolfinx.fem.Form | None":
        form = self._forms.rest_tangent
        return None if form is None else compiled(form)

    @cached_property
    def _blocks(self) -> BlockMatrix:
        cells = self._space.mesh.topology.index_map(3).size_local
        return BlockMatrix(self._form_on_all_cells(), self._space.dofmap.list[:cells])

    def _form_on_all_cells(self) -> "dolfinx.fem.Form":
        """Any form, for its pattern; one that is needed anyway where there is one."""
        rest = self.__dict__.get("_rest_tangent")
        if rest is not None and not self._unformed:
            return rest
        trial, test = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        dx = ufl.Measure("dx", self._space.mesh, metadata={"quadrature_degree": 0})
        return compiled(ufl.inner(trial, test) * dx)

    @cached_property
    def _held_blocks(self) -> HeldBlocks:
        return self._blocks.held_blocks(self._held)

    @cached_property
    def mass(self) -> ConsistentMass:
        """Consistent mass."""
        return ConsistentMass(compiled(self._forms.mass), self._held)

    @cached_property
    def _sum(self) -> "dolfinx.la.Vector":
        return dolfinx.la.vector(self._space.dofmap.index_map, 3)

    def energy(self, local: Array) -> float:
        """Strain energy [J] at a displacement (d, 3) [m]; collective."""
        return float(self.comm.allreduce(sum(part.energy(local) for part in self._parts)))

    def force(self, local: Array) -> Array:
        """Internal force (d, 3) [N] at a displacement (d, 3) [m], complete at owned nodes."""
        force = self._cleared_force()
        for part in self._parts:
            part.add_force(local, force)
        return self._finished_force()

    def _cleared_force(self) -> Array:
        self._sum.array[:] = 0.0
        return self._sum.array.reshape(-1, 3)

    def _finished_force(self) -> Array:
        self._sum.scatter_reverse(dolfinx.la.InsertMode.add)
        return self._sum.array.reshape(-1, 3).copy()

    def empty_matrix(self) -> PETSc.Mat:
        """A matrix of zeros with the entries of K and M; the caller destroys it; collective."""
        return self._blocks.empty()

    def fill_tangent(self, matrix: PETSc.Mat, local: Array, *, diagonal: float = 1.0) -> None:
        """Overwrite a matrix from `empty_matrix` with the tangent, without allocating. Collective.

        Args:
            matrix: from `empty_matrix` of this body, whatever its values.
            local: displacement (d, 3) [m].
            diagonal: entry of the held rows.
        """
        self._add_tangents(local, None)
        self._blocks.write(matrix, self._held_blocks, diagonal=diagonal)

    def linearise(self, matrix: PETSc.Mat, local: Array, *, diagonal: float = 1.0) -> Array:
        """As `fill_tangent`, and the force as by `force`: laws at points are evaluated but once."""
        self._add_tangents(local, self._cleared_force())
        self._blocks.write(matrix, self._held_blocks, diagonal=diagonal)
        return self._finished_force()

    def fill_tangent_derivative(self, matrix: PETSc.Mat, local: Array, direction: Array) -> None:
        """Overwrite a matrix from `empty_matrix` with d/ds K(u + s d) at s = 0, held rows zero.

        Collective.

        Args:
            matrix: from `empty_matrix` of this body, whatever its values.
            local: u (d, 3) [m].
            direction: d (d, 3), zero at held components.
        """
        add_tangent_derivatives(self._parts, local, direction, self._blocks, self.comm)
        self._blocks.write(matrix, self._held_blocks, diagonal=0.0)

    def _add_tangents(self, local: Array, force: Array | None) -> None:
        self._present = local
        self._blocks.clear()
        for part in self._parts:
            part.add_tangent(local, self._blocks, force)

    def _add_rest_tangents(self) -> None:
        rest = self._rest_tangent  # before the blocks, which may take their pattern from it
        self._blocks.clear()
        if rest is not None:
            add_form(rest, self._blocks)
        for part in self._unformed:
            part.add_tangent(np.zeros((len(self._held), 3)), self._blocks, None)

    def add_form(self, matrix: PETSc.Mat, form: "dolfinx.fem.Form") -> None:
        """Add a compiled bilinear form to a matrix from `empty_matrix`, not in held rows.

        Collective.
        """
        self._blocks.clear()
        add_form(form, self._blocks)
        self._blocks.write(matrix, self._held_blocks, diagonal=0.0, add=True)

    def diagonal_blocks(self, matrix: PETSc.Mat) -> Array:
        """(owned nodes, 3, 3) diagonal blocks of a symmetric matrix from `empty_matrix`."""
        return self._blocks.diagonal_blocks(matrix)

    def level_held_rows(self, matrix: PETSc.Mat) -> None:
        """Give held rows of a matrix from `empty_matrix` a diagonal of the others' size."""
        diagonal = self.diagonal_blocks(matrix)[:, range(3), range(3)]
        held = self._held[: self.owned]
        total, count = float(diagonal[~held].sum()), int((~held).sum())
        mean = self.comm.allreduce(total) / max(self.comm.allreduce(count), 1)
        self._blocks.set_diagonal(matrix, self._held, mean)

    def rigid_motions(self) -> Array:
        """Six rigid motions (owned dofs, 6) of the present shape, zero at held components.

        The present shape is that of the last tangent. For multigrid, which should know the motions
        that hardly strain. Collective.
        """
        x = (self._space.tabulate_dof_coordinates() + self._present)[: self.owned]
        x -= self.comm.allreduce(x.sum(axis=0)) / self._space.dofmap.index_map.size_global
        motions = np.zeros((self.owned, 3, 6))
        for axis in range(3):
            motions[:, axis, axis] = 1.0
            motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], x)
        motions[self._held[: self.owned]] = 0.0
        return motions.reshape(-1, 6)

    def stiffness_matrix(self, local: Array | None = None, *, diagonal: float = 1.0) -> PETSc.Mat:
        """Tangent for solving, held rows replaced; the caller destroys it.

        Args:
            local: displacement (d, 3) [m]; None for the rest shape.
            diagonal: entry of the held rows.
        """
        return self._matrix(local, self._held_blocks, diagonal)

    def pencil(self, stiffness: PETSc.Mat) -> Pencil:
        """Products with a matrix from `stiffness_matrix`, while it lives, and with the mass."""
        return Pencil(self._blocks, stiffness, self.mass)

    def _matrix(self, local: Array | None, held: HeldBlocks | None, diagonal: float) -> PETSc.Mat:
        if local is None:
            self._add_rest_tangents()
        else:
            self._add_tangents(local, None)
        matrix = self.empty_matrix()
        self._blocks.write(matrix, held, diagonal=diagonal)
        return matrix

    def unconstrained_tangent(self, local: Array | None) -> Entries:
        """Rows, columns (global dofs of the space) and values of this rank's part of K(u)."""
        matrix = self._matrix(local, None, 0.0)
        plain = matrix.convert("aij", PETSc.Mat())
        first, _ = plain.getOwnershipRange()
        offsets, columns, values = (np.array(part) for part in plain.getValuesCSR())
        plain.destroy()
        matrix.destroy()
        rows = first + np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        return rows.astype(np.int64), columns.astype(np.int64), values

    def lumped_mass(self) -> Array:
        """Mass of this rank's nodes (d,) [kg], complete at owned nodes; collective."""
        diagonal = self.mass.diagonal()
        diagonal *= self.mass.total() / self.comm.allreduce(float(diagonal.sum()))
        return np.append(diagonal, np.zeros(len(self._held) - self.owned))
