"""The consistent mass: one scalar matrix for all three components of the displacement."""

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fenics_defo.fem.compat import dolfinx

Array = NDArray[np.float64]
Entries = tuple[NDArray[np.int64], NDArray[np.int64], Array]


class ConsistentMass:
    """M = m ⊗ I₃ with mᵢⱼ = ∫ ρ Nᵢ Nⱼ dX, by this rank's rows; collective.

    One product reads m once for all components of all vectors, a ninth of what M would be in 3x3
    blocks.

    Args:
        form: ∫ ρ u v dX on the scalar space of the displacement's nodes, compiled.
        held: (d, 3) bool, components that are zero, of this rank's nodes, owned ones first.
    """

    def __init__(self, form: "dolfinx.fem.Form", held: NDArray[np.bool_]) -> None:
        table = dolfinx.fem.assemble_matrix(form)
        table.scatter_reverse()
        # The columns' map has more ghosts than the space: nodes of other ranks' cells.
        self._rows, self._columns = table.index_map(0), table.index_map(1)
        owned = self._rows.size_local
        end = table.indptr[owned]
        self._scalar = sparse.csr_array(
            (table.data[:end], table.indices[:end], table.indptr[: owned + 1]),
            shape=(owned, owned + self._columns.num_ghosts),
        )
        self._held = held[:owned]
        #: Owned dofs that are held.
        self.held_rows = np.flatnonzero(self._held)

    def apply(self, fields: Array) -> Array:
        """M times fields (owned nodes, c): (owned nodes, c) [kg]."""
        return np.asarray(self._scalar @ self._with_ghosts(fields))

    def _with_ghosts(self, fields: Array) -> Array:
        if self._columns.comm.size == 1:
            return fields
        width = fields.shape[1]
        ghosted = dolfinx.la.vector(self._columns, width)
        ghosted.array[: fields.size] = fields.ravel()
        ghosted.scatter_forward()
        return np.asarray(ghosted.array).reshape(-1, width)

    def multiply(self, block: Array) -> Array:
        """M times vectors that are zero at held components, and zero there too.

        Args:
            block: (owned dofs, b).

        Returns:
            (owned dofs, b) in Fortran order.
        """
        rows, width = block.shape
        fields = np.ascontiguousarray(block).reshape(rows // 3, 3 * width)
        product = self.apply(fields).reshape(rows, width)
        product[self.held_rows] = 0.0
        return np.asfortranarray(product)

    def diagonal(self) -> Array:
        """Diagonal of m (owned nodes,) [kg]."""
        return np.asarray(self._scalar.diagonal())

    def total(self) -> float:
        """Mass of the body [kg]."""
        return float(self._rows.comm.allreduce(float(self._scalar.data.sum())))

    def on_pattern(
        self,
        first: NDArray[np.int64],
        columns: NDArray[np.int32],
        nodes: "dolfinx.common.IndexMap",
    ) -> Array:
        """Entries of m (e,) on the pattern of the stiffness in blocks, which is m's own.

        Args:
            first: (owned nodes + 1,) where each row begins.
            columns: (e,) nodes, ghosts included.
            nodes: their map.
        """
        assert np.array_equal(nodes.ghosts, self._columns.ghosts)
        assert np.array_equal(first, self._scalar.indptr)
        assert np.array_equal(columns, self._scalar.indices)
        return np.ascontiguousarray(self._scalar.data)

    def matrix(self) -> PETSc.Mat:
        """M in 3x3 blocks with the rows and columns of held components zero; the caller's."""
        scalar, held = self._scalar, self._with_ghosts(self._held.astype(np.float64)) > 0.0
        blocks = np.zeros((scalar.nnz, 3, 3))
        for c in range(3):
            blocks[:, c, c] = scalar.data
            blocks[held[self._row_of_entries(), c] | held[scalar.indices, c], c, c] = 0.0
        size = (3 * self._rows.size_local, 3 * self._rows.size_global)
        columns = self._columns.local_to_global(scalar.indices).astype(PETSc.IntType)
        csr = (scalar.indptr.astype(PETSc.IntType), columns, blocks.ravel())
        matrix = PETSc.Mat().createBAIJ((size, size), bsize=3, csr=csr, comm=self._rows.comm)
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return matrix

    def entries(self) -> Entries:
        """Rows, columns (global dofs) and values of this rank's part of M, without constraints."""
        rows = self._rows.local_range[0] + self._row_of_entries()
        columns = self._columns.local_to_global(self._scalar.indices)
        component = np.arange(3)
        return (
            (3 * rows[:, None] + component).ravel(),
            (3 * columns[:, None] + component).ravel(),
            np.repeat(self._scalar.data, 3),
        )

    def _row_of_entries(self) -> NDArray[np.intp]:
        return np.repeat(np.arange(self._scalar.shape[0]), np.diff(self._scalar.indptr))
