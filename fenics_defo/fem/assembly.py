"""Compiled forms and PETSc matrices of a body. Its handles stay inside ``fem`` and ``analysis``."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.forms import BodyForms
from fenics_defo.fem.mass import ConsistentMass, Entries

Array = NDArray[np.float64]

# The block format inserts 3x3 blocks at once: 2.3 times faster than scalar insertion.
_FORMAT = "baij"


class Assembly:
    """Energy, force and matrices of a body over this rank's nodes, owned ones first.

    Each form is compiled on its first use. Held components are kept in the stiffness that is meant
    for solving as unit rows, and in the mass as zero rows: their eigenvalues lie at infinity.

    Args:
        space: vector-valued displacement space.
        forms: the body's forms on it.
        held: (d, 3) bool, components that are zero.
    """

    def __init__(
        self, space: "dolfinx.fem.FunctionSpace", forms: BodyForms, held: NDArray[np.bool_]
    ) -> None:
        self._space = space
        self._forms = forms
        self._held = held

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

    @cached_property
    def constraints(self) -> "list[dolfinx.fem.DirichletBC]":
        """The held components as DOLFINx boundary conditions."""
        whole = self._held.all(axis=1)
        conditions = []
        if self.comm.allreduce(int(whole.sum())):
            nodes = np.flatnonzero(whole).astype(np.int32)
            conditions.append(dolfinx.fem.dirichletbc(np.zeros(3), nodes, self._space))
        for component in range(3):
            partly = self._held[:, component] & ~whole
            if self.comm.allreduce(int(partly.sum())):
                dofs = (3 * np.flatnonzero(partly) + component).astype(np.int32)
                zero = dolfinx.fem.Constant(self._space.mesh, 0.0)
                conditions.append(dolfinx.fem.dirichletbc(zero, dofs, self._space.sub(component)))
        return conditions

    def _compiled(self, form: ufl.Form) -> "dolfinx.fem.Form":
        return dolfinx.fem.form(form)

    @cached_property
    def _energy(self) -> "dolfinx.fem.Form":
        return self._compiled(self._forms.energy)

    @cached_property
    def _force(self) -> "dolfinx.fem.Form":
        return self._compiled(self._forms.force)

    @cached_property
    def _tangent(self) -> "dolfinx.fem.Form":
        return self._compiled(self._forms.tangent)

    @cached_property
    def _rest_tangent(self) -> "dolfinx.fem.Form":
        return self._compiled(self._forms.rest_tangent)

    @cached_property
    def mass(self) -> ConsistentMass:
        """Consistent mass."""
        return ConsistentMass(self._compiled(self._forms.mass), self._held)

    def _deform(self, local: Array) -> None:
        self._forms.displacement.x.array[:] = local.ravel()

    def energy(self, local: Array) -> float:
        """Strain energy [J] at a displacement (d, 3) [m]; collective."""
        self._deform(local)
        return float(self.comm.allreduce(dolfinx.fem.assemble_scalar(self._energy)))

    def force(self, local: Array) -> Array:
        """Internal force (d, 3) [N] at a displacement (d, 3) [m], complete at owned nodes."""
        self._deform(local)
        return self._vector(self._force)

    def _vector(self, form: "dolfinx.fem.Form") -> Array:
        vector = dolfinx.fem.assemble_vector(form)
        vector.scatter_reverse(dolfinx.la.InsertMode.add)
        return vector.array.reshape(-1, 3).copy()

    def stiffness_matrix(self, local: Array | None = None, *, diagonal: float = 1.0) -> PETSc.Mat:
        """Tangent for solving, held rows replaced; the caller destroys it.

        Args:
            local: displacement (d, 3) [m]; None for the rest shape.
            diagonal: entry of the held rows.
        """
        return self._matrix(self._tangent_form(local), constrained=True, diagonal=diagonal)

    def empty_matrix(self) -> PETSc.Mat:
        """A matrix of zeros with the entries of K and M; the caller destroys it; collective."""
        matrix = dolfinx.fem.petsc.create_matrix(self._rest_tangent, _FORMAT)
        # PETSc gives back what stays unset of the entries when a matrix is assembled first.
        self._fill(matrix, self._rest_tangent, [], 0.0)
        matrix.zeroEntries()
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        return matrix

    def fill_tangent(self, matrix: PETSc.Mat, local: Array, *, diagonal: float = 1.0) -> None:
        """Overwrite a matrix from `empty_matrix` with the tangent, without allocating. Collective.

        Args:
            matrix: from `empty_matrix` of this body, whatever its values.
            local: displacement (d, 3) [m].
            diagonal: entry of the held rows.
        """
        self._fill(matrix, self._tangent_form(local), self.constraints, diagonal)

    def _fill(
        self,
        matrix: PETSc.Mat,
        form: "dolfinx.fem.Form",
        conditions: "list[dolfinx.fem.DirichletBC]",
        diagonal: float,
    ) -> None:
        matrix.zeroEntries()
        dolfinx.fem.petsc.assemble_matrix(matrix, form, bcs=conditions, diag=diagonal)
        matrix.assemble()

    def rigid_motions(self) -> Array:
        """Six rigid motions (owned dofs, 6) of the present shape, zero at held components.

        The present shape is that of the last displacement at which anything was evaluated. For
        multigrid, which should know the motions that hardly strain.
        """
        moved = self._forms.displacement.x.array.reshape(-1, 3)[: self.owned]
        x = self._space.tabulate_dof_coordinates()[: self.owned] + moved
        x -= self.comm.allreduce(x.sum(axis=0)) / self._space.dofmap.index_map.size_global
        motions = np.zeros((self.owned, 3, 6))
        for axis in range(3):
            motions[:, axis, axis] = 1.0
            motions[:, :, 3 + axis] = np.cross(np.eye(3)[axis], x)
        motions[self._held[: self.owned]] = 0.0
        return motions.reshape(-1, 6)

    def with_held(self, held: NDArray[np.bool_]) -> "Assembly":
        """The same body and compiled forms with other components held.

        Args:
            held: (d, 3) bool, all components that are held, the body's own included.
        """
        other = Assembly(self._space, self._forms, held)
        for name in ("_energy", "_force", "_tangent", "_rest_tangent"):
            other.__dict__[name] = getattr(self, name)
        return other

    def _tangent_form(self, local: Array | None) -> "dolfinx.fem.Form":
        if local is None:
            return self._rest_tangent
        self._deform(local)
        return self._tangent

    def _matrix(
        self, form: "dolfinx.fem.Form", *, constrained: bool, diagonal: float = 1.0
    ) -> PETSc.Mat:
        matrix = self.empty_matrix()
        self._fill(matrix, form, self.constraints if constrained else [], diagonal)
        return matrix

    def unconstrained_tangent(self, local: Array | None) -> Entries:
        """Rows, columns (global dofs of the space) and values of this rank's part of K(u)."""
        return self._entries(self._tangent_form(local))

    def _entries(self, form: "dolfinx.fem.Form") -> Entries:
        with _destroyed(self._matrix(form, constrained=False)) as matrix:
            plain = matrix.convert("aij", PETSc.Mat())
            first, _ = plain.getOwnershipRange()
            offsets, columns, values = (np.array(part) for part in plain.getValuesCSR())
            plain.destroy()
        rows = first + np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        return rows.astype(np.int64), columns.astype(np.int64), values

    def lumped_mass(self) -> Array:
        """Mass of this rank's nodes (d,) [kg], complete at owned nodes; collective."""
        diagonal = self.mass.diagonal()
        diagonal *= self.mass.total() / self.comm.allreduce(float(diagonal.sum()))
        return np.append(diagonal, np.zeros(len(self._held) - self.owned))


@contextmanager
def _destroyed(matrix: PETSc.Mat) -> Iterator[PETSc.Mat]:
    try:
        yield matrix
    finally:
        matrix.destroy()
