"""The pattern of a body's stiffness in 3x3 blocks, and the work array that it is added up in."""

from functools import cached_property

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.cell_kernels import block_positions, write_blocks
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.petsc_blocks import block_values, mark_changed

Array = NDArray[np.float64]
Blocks = NDArray[np.int32]


class BlockMatrix:
    """Blocks between all nodes that share a cell, those of ghost rows included.

    Filled in three steps: `clear`, any number of additions to `values` at `positions`, and `write`,
    which brings the ghosts' rows to their owners and copies all into a matrix of PETSc's. Adding up
    here is three times faster than through PETSc's own insertion.

    Args:
        form: any compiled bilinear form on all cells, for its pattern.
        nodes: (c, n) nodes of the cells that this rank owns.
    """

    def __init__(self, form: "dolfinx.fem.Form", nodes: NDArray[np.int32]) -> None:
        self._csr = dolfinx.fem.create_matrix(form)
        assert self._csr.block_size == [3, 3]
        #: DOLFINx's map of the nodes in columns, ghosts included.
        self.columns = self._csr.index_map(1)
        self._rows = self._csr.index_map(0)
        self.owned = self._rows.size_local
        indptr, indices = np.asarray(self._csr.indptr), np.asarray(self._csr.indices)
        self._indptr, self._indices = indptr[: self.owned + 1], indices[: indptr[self.owned]]
        #: (b, 3, 3) blocks of this rank's rows, then of its ghosts'.
        self.values: Array = self._csr.data.reshape(-1, 3, 3)
        self._pattern = (np.ascontiguousarray(indptr, np.int64), indices)
        #: (c, n, n) number of the block of each pair of a cell's nodes.
        self.positions = block_positions(np.ascontiguousarray(nodes), *self._pattern)
        self._chosen = self._order()

    def positions_of(self, nodes: NDArray[np.int32]) -> NDArray[np.int32]:
        """(e, n, n) number of the block of each pair of nodes (e, n), which share a cell."""
        return block_positions(np.ascontiguousarray(nodes, np.int32), *self._pattern)

    def _order(self) -> tuple[Blocks, Blocks]:
        """Owned rows' blocks in PETSc's order: in this rank's columns, then in others'."""
        own = self._indices < self.owned
        other = np.flatnonzero(~own)
        columns = self.columns.local_to_global(self._indices[other])
        by_column = np.lexsort((columns, self._row_of_blocks[other]))
        return np.flatnonzero(own).astype(np.int32), other[by_column].astype(np.int32)

    @cached_property
    def _row_of_blocks(self) -> NDArray[np.intp]:
        return np.repeat(np.arange(self.owned), np.diff(self._indptr))

    @cached_property
    def diagonal(self) -> Blocks:
        """(owned,) number of each owned row's diagonal block."""
        return np.flatnonzero(self._indices == self._row_of_blocks).astype(np.int32)

    @cached_property
    def _diagonal_in_petsc(self) -> Blocks:
        return np.searchsorted(self._chosen[0], self.diagonal).astype(np.int32)

    def clear(self) -> None:
        """Set all blocks to zero."""
        self.values[:] = 0.0

    def empty(self) -> PETSc.Mat:
        """A symmetric matrix of PETSc's with this pattern and zeros; the caller's; collective."""
        size = (3 * self._rows.size_local, 3 * self._rows.size_global)
        columns = self.columns.local_to_global(self._indices).astype(PETSc.IntType)
        csr = (self._indptr.astype(PETSc.IntType), columns, np.zeros(9 * len(columns)))
        matrix = PETSc.Mat().createBAIJ((size, size), bsize=3, csr=csr, comm=self._rows.comm)
        matrix.setLGMap(*(self._numbers_on_all_ranks(map_) for map_ in (self._rows, self.columns)))
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        return matrix

    @staticmethod
    def _numbers_on_all_ranks(index_map: "dolfinx.common.IndexMap") -> PETSc.LGMap:
        """For DOLFINx's own loops, should they fill the matrix."""
        count = index_map.size_local + index_map.num_ghosts
        numbers = index_map.local_to_global(np.arange(count, dtype=np.int32))
        return PETSc.LGMap().create(numbers.astype(PETSc.IntType), bsize=3, comm=index_map.comm)

    def write(
        self, matrix: PETSc.Mat, held: "HeldBlocks | None", *, diagonal: float, add: bool = False
    ) -> None:
        """Bring the sums to a matrix from `empty`; collective.

        Args:
            matrix: overwritten, or added to.
            held: components whose rows and columns become zero.
            diagonal: entry of the held rows where the matrix is overwritten.
            add: whether the matrix is added to.
        """
        self._csr.scatter_reverse()
        if held is not None:
            held.clear(self.values, 0.0 if add else diagonal)
        for chosen, target in zip(self._chosen, self._petsc_values(matrix), strict=True):
            write_blocks(chosen, self.values, target, add=add)
        mark_changed(matrix)

    def local_rows(self, matrix: PETSc.Mat) -> tuple[NDArray[np.int64], Blocks, Array]:
        """Owned rows of a matrix from `empty`: their first entries, nodes of columns, values.

        Returns:
            (owned + 1,) where each row begins; (b,) columns by `columns`, ghosts included; (b, 9)
            blocks, each stored column by column, on one rank PETSc's own.
        """
        first, indices = self._pattern
        own, other = self._petsc_values(matrix)
        values = own
        if len(other):
            values = np.empty((len(self._indices), 9))
            for chosen, source in zip(self._chosen, (own, other), strict=True):
                values[chosen] = source
        return first[: self.owned + 1], indices[: len(self._indices)], values

    def diagonal_blocks(self, matrix: PETSc.Mat) -> Array:
        """(owned, 3, 3) diagonal blocks of a symmetric matrix from `empty`."""
        own, _ = self._petsc_values(matrix)
        return own[self._diagonal_in_petsc].reshape(-1, 3, 3)

    def set_diagonal(self, matrix: PETSc.Mat, components: NDArray[np.bool_], value: float) -> None:
        """Set the diagonal entries of components (d, 3) of a matrix from `empty`."""
        rows, places = np.nonzero(components[: self.owned])
        own, _ = self._petsc_values(matrix)
        own[self._diagonal_in_petsc[rows], 4 * places] = value
        mark_changed(matrix)

    def _petsc_values(self, matrix: PETSc.Mat) -> tuple[Array, Array]:
        first, second = self._chosen
        return block_values(matrix, (len(first), len(second)))

    def held_blocks(self, held: NDArray[np.bool_]) -> "HeldBlocks":
        """Where the rows and columns of held components (d, 3) lie; collective."""
        ghosted = dolfinx.la.vector(self.columns, 3)
        ghosted.array[: 3 * self.owned] = held[: self.owned].ravel()
        ghosted.scatter_forward()
        by_column = np.asarray(ghosted.array).reshape(-1, 3) > 0.0
        touched = by_column.any(axis=1)
        blocks = np.flatnonzero(touched[self._row_of_blocks] | touched[self._indices])
        rows, columns = self._row_of_blocks[blocks], self._indices[blocks]
        mask = by_column[rows][:, :, None] | by_column[columns][:, None, :]
        own_rows, components = np.nonzero(held[: self.owned])
        return HeldBlocks(blocks, mask, self.diagonal[own_rows], components)


class HeldBlocks:
    """Entries in the rows and columns of held components.

    Args:
        blocks: (k,) blocks that hold any.
        mask: (k, 3, 3) those entries.
        diagonal: (h,) blocks of the held components' diagonal entries.
        components: (h,) those components.
    """

    def __init__(
        self,
        blocks: NDArray[np.intp],
        mask: NDArray[np.bool_],
        diagonal: Blocks,
        components: NDArray[np.intp],
    ) -> None:
        self._blocks, self._kept = blocks, (~mask).astype(np.float64)
        self._diagonal, self._components = diagonal, components

    def clear(self, values: Array, diagonal: float) -> None:
        """Set the entries to zero, and those on the diagonal to a number."""
        values[self._blocks] = np.where(self._kept > 0.0, values[self._blocks], 0.0)
        values[self._diagonal, self._components, self._components] = diagonal
