"""From arrays in the file's order on one rank to a DOLFINx mesh on all of them."""

from collections.abc import Callable

import basix.ufl
import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fenics_defo.energy import material_from_table
from fenics_defo.errors import DefoError
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.imported import EntityGroup, ImportedMesh, MeshRecord
from fenics_defo.fem.sources import Group, SourceMesh

_TAG_NAMES = {3: "cell_tags", 2: "facet_tags", 1: "ridge_tags", 0: "peak_tags"}


def on_first_rank[T](comm: MPI.Comm, work: Callable[[], T]) -> T:
    """Do something on rank 0 only and give its result, or its error, to all ranks.

    Collective. An error of ours is raised on each rank, so that none waits for the others for ever.

    Args:
        comm: communicator.
        work: what rank 0 does.

    Returns:
        what ``work`` returned, on each rank.
    """
    outcome: tuple[T | None, DefoError | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (work(), None)
        except DefoError as error:
            outcome = (None, error)
    result, error = comm.bcast(outcome, root=0)
    if error is not None:
        raise error
    return result


def distribute(comm: MPI.Comm, source: SourceMesh) -> ImportedMesh:
    """Spread a checked mesh over the ranks, with its groups as DOLFINx tags.

    Collective.

    Args:
        comm: communicator of the mesh.
        source: the mesh, the same on each rank.

    Returns:
        DOLFINx's ``MeshData`` with its ``record``. A cell or facet in several groups carries in the tags the
        lowest number; the record's groups are complete.
    """
    from_vtk = dolfinx.cpp.io.perm_vtk(
        dolfinx.cpp.mesh.to_type(source.kind), source.cells.shape[1]
    )
    first = comm.rank == 0
    mesh = dolfinx.mesh.create_mesh(
        comm,
        np.ascontiguousarray(source.cells[:, from_vtk] if first else source.cells[:0]),
        basix.ufl.element(
            "Lagrange", source.kind, source.order, basix.LagrangeVariant.equispaced, shape=(3,)
        ),
        np.ascontiguousarray(source.points if first else source.points[:0]),
    )
    groups = tuple(_local_group(mesh, group) for group in source.groups)
    record = MeshRecord(
        path=source.path,
        node_numbers=source.node_numbers,
        cell_numbers=source.cell_numbers,
        groups=groups,
        materials=dict(
            material_from_table(
                {"law": item.law, **item.constants}
                | ({} if item.region is None else {"region": item.region})
            )
            for item in source.materials
        ),
        notes=source.notes,
    )
    tags = {name: _tags(mesh, groups, dimension) for dimension, name in _TAG_NAMES.items()}
    physical = {
        group.name: dolfinx.io.gmsh.PhysicalGroup(group.dimension, group.number)
        for group in reversed(groups)
    }
    mesh_data = ImportedMesh(mesh=mesh, physical_groups=physical, **tags)
    mesh_data.record = record
    return mesh_data


def _local_group(mesh: "dolfinx.mesh.Mesh", group: Group) -> EntityGroup:
    if group.dimension == 3:
        chosen = np.isin(mesh.topology.original_cell_index, group.entities)
        entities = np.flatnonzero(chosen).astype(np.int32)
    else:
        entities = _entities_with_vertices(mesh, group.dimension, group.entities)
    return EntityGroup(
        name=group.name,
        number=group.number,
        dimension=group.dimension,
        entities=entities,
        size=len(group.entities),
    )


def _entities_with_vertices(
    mesh: "dolfinx.mesh.Mesh", dimension: int, vertices: NDArray[np.int64]
) -> NDArray[np.int32]:
    """This rank's entities whose corner vertices, as input node indices, are among the rows of ``vertices``."""
    mesh.topology.create_entities(dimension)
    mesh.topology.create_connectivity(dimension, mesh.topology.dim)
    index_map = mesh.topology.index_map(dimension)
    local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
    corners = dolfinx.mesh.entities_to_geometry(mesh, dimension, local)
    own = np.sort(mesh.geometry.input_global_indices[corners], axis=1)
    wanted = np.sort(vertices, axis=1)
    return np.flatnonzero(np.isin(_row_keys(own), _row_keys(wanted))).astype(np.int32)


def _row_keys(rows: NDArray[np.int64]) -> NDArray[np.void]:
    """One comparable value a row."""
    rows = np.ascontiguousarray(rows, dtype=np.int64)
    return rows.view([("", np.int64)] * rows.shape[1]).ravel()


def _tags(
    mesh: "dolfinx.mesh.Mesh", groups: tuple[EntityGroup, ...], dimension: int
) -> "dolfinx.mesh.MeshTags | None":
    mine = sorted((g for g in groups if g.dimension == dimension), key=lambda g: g.number)
    if not mine:
        return None
    entities = np.concatenate([group.entities for group in mine])
    numbers = np.concatenate([np.full(len(g.entities), g.number, np.int32) for g in mine])
    unique, at = np.unique(entities, return_index=True)  # the first, so the lowest number
    tags = dolfinx.mesh.meshtags(mesh, dimension, unique, numbers[at])
    tags.name = _TAG_NAMES[dimension]
    return tags
