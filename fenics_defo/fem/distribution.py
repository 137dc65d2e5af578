"""From arrays in the file's order on one rank to a DOLFINx mesh on all of them."""

from dataclasses import replace

from mpi4py import MPI

import basix.ufl
import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import Law, material_from_table
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.entities import all_entities, corner_nodes
from fenics_defo.fem.imported import EntityGroup, ImportedMesh, MeshRecord
from fenics_defo.fem.sources import Group, SourceMesh

_TAG_NAMES = {3: "cell_tags", 2: "facet_tags", 1: "ridge_tags", 0: "peak_tags"}


def without_arrays(source: SourceMesh) -> SourceMesh:
    """What ranks other than the first need of a mesh: all but its points and cells."""
    return replace(source, points=source.points[:0], cells=source.cells[:0])


def distribute(comm: MPI.Comm, source: SourceMesh) -> ImportedMesh:
    """Spread a checked mesh over the ranks, with its groups as DOLFINx tags.

    Collective.

    Args:
        comm: communicator of the mesh.
        source: the mesh; points and cells are used on rank 0 only, see `without_arrays`.

    Returns:
        DOLFINx's ``MeshData`` with its ``record``. A cell or facet in several groups carries in
        the tags the lowest number; the record's groups are complete.

    Raises:
        MaterialError: a material of the file has constants outside their range.
    """
    materials = _materials(source)
    mesh = _mesh(comm, source)
    groups = tuple(_local_group(mesh, group) for group in source.groups)
    tags = {name: _tags(mesh, groups, dimension) for dimension, name in _TAG_NAMES.items()}
    physical = {
        group.name: dolfinx.io.gmsh.PhysicalGroup(group.dimension, group.number)
        for group in reversed(groups)
    }
    mesh_data = ImportedMesh(mesh=mesh, physical_groups=physical, **tags)
    mesh_data.record = MeshRecord(
        path=source.path,
        node_numbers=source.node_numbers,
        cell_numbers=source.cell_numbers,
        groups=groups,
        materials=materials,
        notes=source.notes,
    )
    return mesh_data


def _materials(source: SourceMesh) -> dict[str | None, Law]:
    found: dict[str | None, Law] = {}
    for item in source.materials:
        region = {} if item.region is None else {"region": item.region}
        name, material = material_from_table({"law": item.law, **item.constants, **region})
        # Of overlapping regions the last holds: a region named again moves to the end, and a
        # material of the whole body covers all before it.
        if name is None:
            found.clear()
        found.pop(name, None)
        found[name] = material
    return found


def _mesh(comm: MPI.Comm, source: SourceMesh) -> "dolfinx.mesh.Mesh":
    from_vtk = dolfinx.cpp.io.perm_vtk(dolfinx.cpp.mesh.to_type(source.kind), source.cells.shape[1])
    if comm.rank != 0:
        source = without_arrays(source)
    return dolfinx.mesh.create_mesh(
        comm,
        np.ascontiguousarray(source.cells[:, from_vtk]),
        basix.ufl.element(
            "Lagrange", source.kind, source.order, basix.LagrangeVariant.equispaced, shape=(3,)
        ),
        np.ascontiguousarray(source.points),
    )


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
        nodes=group.entities.ravel() if group.dimension == 0 else None,
    )


def _entities_with_vertices(
    mesh: "dolfinx.mesh.Mesh", dimension: int, vertices: NDArray[np.int64]
) -> NDArray[np.int32]:
    """This rank's entities whose corners, as input node indices, are a row of ``vertices``."""
    local = all_entities(mesh, dimension)
    corners = corner_nodes(mesh, dimension, local)
    nodes = mesh.geometry.input_global_indices
    # Most entities have no corner, or not all, in the group: only the others are sorted.
    local = local[np.isin(nodes, vertices)[corners].all(axis=1)]
    found = np.sort(nodes[corners[local]], axis=1)
    known = np.sort(vertices[np.isin(vertices, nodes).all(axis=1)], axis=1)
    keys = _row_keys(np.vstack([found, known]))
    return local[np.isin(keys[: len(found)], keys[len(found) :])]


def _row_keys(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """One integer a row, equal for equal rows; many times faster than sorting rows as such."""
    keys = np.zeros(len(rows), np.int64)
    span = int(rows.max(initial=0)) + 1
    for column in rows.T:
        # The ranks of the keys so far keep the products far below 2⁶³.
        keys = np.unique(keys, return_inverse=True)[1] * span + column
    return keys


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
