"""The one place that knows how DOLFINx numbers nodes: everything the user sees is in the order of the file."""

from dataclasses import dataclass
from functools import cached_property

import basix
import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy import sparse

from fenics_defo.fem.compat import dolfinx

_CELL_NAMES = {
    ("tetrahedron", 1): "tetra",
    ("tetrahedron", 2): "tetra10",
    ("hexahedron", 1): "hexahedron",
    ("hexahedron", 2): "hexahedron27",
}


@dataclass(frozen=True)
class NodeNumbering:
    """Where each degree of freedom of a displacement space lies in the user's list of nodes.

    The list begins with the n₀ nodes of the user's mesh in the order of its file; order 2 on a mesh of straight
    first-order cells appends its extra nodes, in the order in which the file's cells first use them.

    Args:
        comm: communicator of the space.
        points: (n, 3) coordinates [m].
        cells: (m, c) int64 rows of ``points``, cells in the file's order, nodes in VTK's order.
        cell_type: VTK's name of the cell: "tetra", "tetra10", "hexahedron" or "hexahedron27".
        rows: (d,) int64, row of ``points`` of each of this rank's nodes of the space, ghosts last.
        owned: how many of ``rows`` this rank owns.
        corner_weights: (n, n) sparse: values of the first-order functions of the corner nodes at each node; the
            unit row at corner nodes. It carries first-order displacements to the mid nodes of a curved mesh.
        carried: (n,) bool, true where a node is one of the space's own.
    """

    comm: MPI.Comm
    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    cell_type: str
    rows: NDArray[np.int64]
    owned: int
    corner_weights: sparse.csr_array
    carried: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """Number n of nodes."""
        return len(self.points)

    def gather(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Collect values at this rank's own nodes into one array, on each rank.

        Collective. Mid nodes that the space does not carry get the first-order interpolation.

        Args:
            local: (d or more, ...) values at this rank's nodes, owned first.

        Returns:
            (n, ...) values in the user's order.
        """
        table = self._collect(local)
        if self.carried.all():
            return table
        flat = self.corner_weights @ table.reshape(self.size, -1)
        return flat.reshape(table.shape)

    def gather_own(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """As :meth:`gather`, with zeros at nodes that the space does not carry: for forces and masses."""
        return self._collect(local)

    def _collect(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        own = np.ascontiguousarray(local[: self.owned])
        table = np.zeros((self.size, *own.shape[1:]))
        if self.comm.size == 1:
            table[self.rows[: self.owned]] = own
            return table
        for rank in range(self.comm.size):  # rank by rank: no array larger than the result
            rows, values = self.comm.bcast(
                (self.rows[: self.owned], own) if self.comm.rank == rank else None, root=rank
            )
            table[rows] = values
        return table

    def scatter(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """This rank's part, ghosts included, of values given at all nodes: (n, ...) -> (d, ...)."""
        return values[self.rows]

    @cached_property
    def global_rows(self) -> NDArray[np.int64]:
        """(D,) row of ``points`` of each node of the space by its global index; collective."""
        return np.concatenate(self.comm.allgather(self.rows[: self.owned]))


def number_nodes(space: "dolfinx.fem.FunctionSpace", cell_count: int) -> NodeNumbering:
    """Relate the nodes of a Lagrange space to those of the user's mesh.

    Collective.

    Args:
        space: vector-valued Lagrange space of order 1 or 2.
        cell_count: number m of cells of the whole mesh.

    Returns:
        the numbering.
    """
    mesh, comm = space.mesh, space.mesh.comm
    kind = mesh.topology.cell_name()
    order, mesh_order = space.element.basix_element.degree, mesh.geometry.cmap.degree
    owned_cells = mesh.topology.index_map(3).size_local
    original = mesh.topology.original_cell_index[:owned_cells]
    geometry = mesh.geometry.input_global_indices[mesh.geometry.dofmap]
    dofs = space.dofmap.list
    file_nodes = mesh.geometry.index_map().size_global

    table = _in_file_order(comm, original, geometry[:owned_cells], cell_count)
    index_map = space.dofmap.index_map
    rows = np.empty(index_map.size_local + index_map.num_ghosts, np.int64)
    if order > mesh_order:
        global_dofs = index_map.local_to_global(dofs[:owned_cells].ravel()).reshape(-1, dofs.shape[1])
        cell_dofs = _in_file_order(comm, original, global_dofs, cell_count)
        row_of_dof = _append_extra_nodes(table, cell_dofs, file_nodes, kind)
        rows[:] = row_of_dof[index_map.local_to_global(np.arange(len(rows), dtype=np.int32))]
        cells = row_of_dof[cell_dofs]
    else:
        corners = dofs.shape[1]
        rows[dofs] = geometry[:, :corners]
        cells = table
    count = int(cells.max()) + 1
    carried = np.zeros(count, bool)
    for part in comm.allgather(rows[: index_map.size_local]):
        carried[part] = True
    weights = _corner_weights(cells, kind, max(order, mesh_order), count)
    points = _points(mesh, comm, file_nodes)
    if count > file_nodes:
        padded = np.vstack([points, np.zeros((count - file_nodes, 3))])
        points = np.vstack([points, (weights @ padded)[file_nodes:]])
    to_vtk = np.argsort(dolfinx.cpp.io.perm_vtk(mesh.topology.cell_type, cells.shape[1]))
    return NodeNumbering(
        comm=comm,
        points=points,
        cells=np.ascontiguousarray(cells[:, to_vtk]),
        cell_type=_CELL_NAMES[kind, max(order, mesh_order)],
        rows=rows,
        owned=index_map.size_local,
        corner_weights=weights,
        carried=carried,
    )


def _in_file_order(
    comm: MPI.Comm, original: NDArray[np.int64], local: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """Rows of all ranks' cells in the file's order, on each rank."""
    table = np.empty((count, local.shape[1]), np.int64)
    for places, values in comm.allgather((original, local)):
        table[places] = values
    return table


def _points(mesh: "dolfinx.mesh.Mesh", comm: MPI.Comm, count: int) -> NDArray[np.float64]:
    points = np.empty((count, 3))
    for places, values in comm.allgather((mesh.geometry.input_global_indices, mesh.geometry.x)):
        points[places] = values
    return points


def _append_extra_nodes(
    corners: NDArray[np.int64], cell_dofs: NDArray[np.int64], file_nodes: int, kind: str
) -> NDArray[np.int64]:
    """Row of each global dof: the file's for corners, then by first use in the file's cells, VTK's order."""
    row_of_dof = np.full(int(cell_dofs.max()) + 1, -1, np.int64)
    row_of_dof[cell_dofs[:, : corners.shape[1]]] = corners
    to_vtk = np.argsort(
        dolfinx.cpp.io.perm_vtk(dolfinx.cpp.mesh.to_type(kind), cell_dofs.shape[1])
    )
    used = cell_dofs[:, to_vtk][:, corners.shape[1] :].ravel()
    extra, first = np.unique(used, return_index=True)
    row_of_dof[extra[np.argsort(first)]] = file_nodes + np.arange(len(extra))
    return row_of_dof


def _corner_weights(
    cells: NDArray[np.int64], kind: str, order: int, count: int
) -> sparse.csr_array:
    """(count, count) first-order functions of the corners at each node of cells in DOLFINx's order."""
    cell = basix.CellType[kind]
    linear = basix.create_element(basix.ElementFamily.P, cell, 1)
    full = basix.create_element(
        basix.ElementFamily.P, cell, order, basix.LagrangeVariant.equispaced
    )
    values = linear.tabulate(0, full.points)[0, :, :, 0]
    values[np.abs(values) < 1e-12] = 0.0
    nodes, at = np.unique(cells, return_index=True)
    cell_of_node, place = np.divmod(at, cells.shape[1])
    corner = cells[cell_of_node][:, : values.shape[1]]
    entries = values[place]
    rows = np.repeat(nodes, values.shape[1])
    matrix = sparse.csr_array((entries.ravel(), (rows, corner.ravel())), shape=(count, count))
    matrix.eliminate_zeros()
    return matrix
