"""In which order the input named the nodes and cells that DOLFINx has renumbered and spread."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import dolfinx


def input_nodes(mesh: "dolfinx.mesh.Mesh") -> NDArray[np.int64]:
    """Input indices of the mesh's nodes (n,), ascending, on each rank.

    They are 0 to n − 1 unless the input held nodes without a cell, which DOLFINx drops; gmsh
    writes the centres of circles as such nodes. Collective.
    """
    count = mesh.geometry.index_map().size_global
    if _has_all(mesh):
        return np.arange(count)
    own = mesh.geometry.input_global_indices[: mesh.geometry.index_map().size_local]
    return np.sort(np.concatenate(mesh.comm.allgather(own)))


def node_rows(mesh: "dolfinx.mesh.Mesh") -> NDArray[np.int64]:
    """Row, in the list of the input's nodes, of each of this rank's geometry nodes; collective."""
    indices = mesh.geometry.input_global_indices
    return indices if _has_all(mesh) else np.searchsorted(input_nodes(mesh), indices)


def cell_rows(mesh: "dolfinx.mesh.Mesh") -> NDArray[np.int64]:
    """Row, in the list of the input's cells, of each of this rank's cells, ghosts last.

    A submesh has no input: its cells count in DOLFINx's own order.
    """
    try:
        return mesh.topology.original_cell_index
    except RuntimeError:
        index_map = mesh.topology.index_map(mesh.topology.dim)
        local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        return index_map.local_to_global(local)


def _has_all(mesh: "dolfinx.mesh.Mesh") -> bool:
    """Whether no node of the input is missing."""
    indices = mesh.geometry.input_global_indices
    largest = max(mesh.comm.allgather(int(indices.max()) if len(indices) else -1))
    return largest + 1 == mesh.geometry.index_map().size_global
