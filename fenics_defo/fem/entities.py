"""Vertices, edges, facets and cells of a mesh by their corners."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import dolfinx


def all_entities(mesh: "dolfinx.mesh.Mesh", dimension: int) -> NDArray[np.int32]:
    """(k,) all of this rank's entities, ghosts last."""
    mesh.topology.create_entities(dimension)
    index_map = mesh.topology.index_map(dimension)
    return np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)


def corner_nodes(
    mesh: "dolfinx.mesh.Mesh", dimension: int, entities: NDArray[np.int32]
) -> NDArray[np.int32]:
    """This rank's geometry nodes (k, v) at the corners of entities (k,).

    DOLFINx gives the mid nodes of curved entities too, after the corners.
    """
    mesh.topology.create_connectivity(dimension, mesh.topology.dim)
    nodes = dolfinx.mesh.entities_to_geometry(mesh, dimension, entities)
    tetrahedra = mesh.topology.cell_name() == "tetrahedron"
    return nodes[:, : dimension + 1 if tetrahedra else 2**dimension]
