"""The one place that knows how DOLFINx numbers nodes: the user sees the order of the file."""

from dataclasses import dataclass
from functools import cached_property

from mpi4py import MPI

import basix
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.input_order import cell_rows, node_rows

_CELL_NAMES = {
    ("tetrahedron", 1): "tetra",
    ("tetrahedron", 2): "tetra10",
    ("hexahedron", 1): "hexahedron",
    ("hexahedron", 2): "hexahedron27",
}
_CELLS = {name: cell for cell, name in _CELL_NAMES.items()}


@dataclass(frozen=True)
class NodeNumbering:
    """Where each degree of freedom of a displacement space lies in the user's list of nodes.

    The list begins with the n₀ nodes of the user's mesh in the order of its file; order 2 on a
    mesh of straight first-order cells appends its extra nodes, in the order in which the file's
    cells first use them.

    Args:
        comm: communicator of the space.
        points: (n, 3) coordinates [m].
        cells: (m, c) int64 rows of ``points``, cells in the file's order, nodes in VTK's order.
        cell_type: VTK's name of the cell: "tetra", "tetra10", "hexahedron" or "hexahedron27".
        rows: (d,) int64, row of ``points`` of each of this rank's nodes of the space, ghosts last.
        owned: how many of ``rows`` this rank owns.
        file_nodes: number n₀ of the user's nodes.
        carried: (n,) bool, true where a node is one of the space's own.
    """

    comm: MPI.Comm
    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    cell_type: str
    rows: NDArray[np.int64]
    owned: int
    file_nodes: int
    carried: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """Number n of nodes."""
        return len(self.points)

    @cached_property
    def corner_weights(self) -> sparse.csr_array:
        """(n, n) values of the corners' first-order functions at each node.

        Unit rows at corners. It carries first-order displacements to the mid nodes of a curved
        mesh.
        """
        return _corner_weights(self.cells, self.cell_type, self.size)

    def gather(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Collect values at this rank's own nodes into one array, on each rank.

        Collective. Mid nodes that the space does not carry get the first-order interpolation.

        Args:
            local: (d or more, ...) values at this rank's nodes, owned first.

        Returns:
            (n, ...) values in the user's order.
        """
        table = self.gather_own(local)
        if self.carried.all():
            return table
        flat = self.corner_weights @ table.reshape(self.size, -1)
        return flat.reshape(table.shape)

    def gather_own(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """As `gather`, with zeros at nodes that the space does not carry: for forces and masses."""
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

    def scatter[T: np.generic](self, values: NDArray[T]) -> NDArray[T]:
        """This rank's part, ghosts included, of values at all nodes: (n, ...) -> (d, ...)."""
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
    order, mesh_order = space.element.basix_element.degree, mesh.geometry.cmaps[0].degree
    owned_cells = mesh.topology.index_map(3).size_local
    original = cell_rows(mesh)[:owned_cells]
    file_rows = node_rows(mesh)
    geometry = file_rows[mesh.geometry.dofmaps[0]]
    dofs, index_map = space.dofmap.list, space.dofmap.index_map
    points = _points(mesh, file_rows)
    cells = _in_file_order(comm, original, geometry[:owned_cells], cell_count)
    rows = np.empty(index_map.size_local + index_map.num_ghosts, np.int64)
    if order > mesh_order:
        global_dofs = _global_indices(index_map, dofs[:owned_cells])
        cell_dofs = _in_file_order(comm, original, global_dofs, cell_count)
        row_of_dof = _append_extra_nodes(cells, cell_dofs, len(points), kind)
        rows[:] = row_of_dof[_global_indices(index_map, np.arange(len(rows)))]
        cells = row_of_dof[cell_dofs]
    else:
        # Corner nodes come first in the cells of both; of equal orders, all nodes agree.
        rows[dofs] = geometry[:, : dofs.shape[1]]
    cells = np.ascontiguousarray(cells[:, vtk_order(kind, cells.shape[1])])
    cell_type, file_nodes = _CELL_NAMES[kind, max(order, mesh_order)], len(points)
    if order > mesh_order:
        points = _with_extra_points(points, cells, cell_type)
    carried = np.zeros(len(points), bool)
    for part in comm.allgather(rows[: index_map.size_local]):
        carried[part] = True
    return NodeNumbering(
        comm=comm,
        points=points,
        cells=cells,
        cell_type=cell_type,
        rows=rows,
        owned=index_map.size_local,
        file_nodes=file_nodes,
        carried=carried,
    )


def vtk_order(kind: str, nodes: int) -> NDArray[np.intp]:
    """Columns that bring cells with that many nodes from DOLFINx's order to VTK's."""
    return np.argsort(dolfinx.cpp.io.perm_vtk(dolfinx.cpp.mesh.to_type(kind), nodes))


def _global_indices(
    index_map: "dolfinx.common.IndexMap", local: NDArray[np.integer]
) -> NDArray[np.int64]:
    flat = np.ascontiguousarray(local, dtype=np.int32).ravel()
    return index_map.local_to_global(flat).reshape(local.shape)


def _in_file_order(
    comm: MPI.Comm, original: NDArray[np.int64], local: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """Rows of all ranks' cells in the file's order, on each rank."""
    table = np.empty((count, local.shape[1]), np.int64)
    for places, values in comm.allgather((original, local)):
        table[places] = values
    return table


def _points(mesh: "dolfinx.mesh.Mesh", file_rows: NDArray[np.int64]) -> NDArray[np.float64]:
    index_map = mesh.geometry.index_map()
    points = np.empty((index_map.size_global, 3))
    own = slice(index_map.size_local)
    for places, values in mesh.comm.allgather((file_rows[own], mesh.geometry.x[own])):
        points[places] = values
    return points


def _append_extra_nodes(
    corners: NDArray[np.int64], cell_dofs: NDArray[np.int64], file_nodes: int, kind: str
) -> NDArray[np.int64]:
    """Row of each global dof: the file's at corners, then by first use in the file's cells.

    Args:
        corners: (m, v) rows of the cells' corners, DOLFINx's order.
        cell_dofs: (m, c) the cells' global dofs, DOLFINx's order.
        file_nodes: number of the file's nodes.
        kind: cell kind.
    """
    row_of_dof = np.full(int(cell_dofs.max()) + 1, -1, np.int64)
    row_of_dof[cell_dofs[:, : corners.shape[1]]] = corners
    used = cell_dofs[:, vtk_order(kind, cell_dofs.shape[1])][:, corners.shape[1] :].ravel()
    extra, first = np.unique(used, return_index=True)
    row_of_dof[extra[np.argsort(first)]] = file_nodes + np.arange(len(extra))
    return row_of_dof


def _with_extra_points(
    points: NDArray[np.float64], cells: NDArray[np.int64], cell_type: str
) -> NDArray[np.float64]:
    """The file's points and the appended nodes' between them, where the cells' mapping puts them.

    Straight tetrahedra and the three-linear hexahedra alike: it is linear in the corners.
    """
    count = int(cells.max()) + 1
    padded = np.vstack([points, np.zeros((count - len(points), 3))])
    padded[len(points) :] = (_corner_weights(cells, cell_type, count) @ padded)[len(points) :]
    return padded


def _corner_weights(cells: NDArray[np.int64], cell_type: str, count: int) -> sparse.csr_array:
    """(count, count) first-order functions of the corners at each node of VTK cells."""
    kind, order = _CELLS[cell_type]
    linear = basix.create_element(basix.ElementFamily.P, basix.CellType[kind], 1)
    corners = linear.dim
    if order == 1:
        return sparse.eye_array(count, format="csr")
    full = basix.create_element(
        basix.ElementFamily.P, basix.CellType[kind], 2, basix.LagrangeVariant.equispaced
    )
    nodes = full.points[vtk_order(kind, full.dim)]
    values = linear.tabulate(0, nodes)[0, :, :, 0][:, vtk_order(kind, corners)]
    middle, at = np.unique(cells[:, corners:], return_index=True)
    cell, place = np.divmod(at, cells.shape[1] - corners)
    unit = np.setdiff1d(np.arange(count), middle, assume_unique=True)
    entries = np.append(np.ones(len(unit)), values[corners + place])
    rows = np.append(unit, np.repeat(middle, corners))
    columns = np.append(unit, cells[cell, :corners])
    entries[np.abs(entries) < 1e-12] = 0.0
    matrix = sparse.csr_array((entries, (rows, columns)), shape=(count, count))
    matrix.eliminate_zeros()
    return matrix
