"""Selections resolved on a mesh: which nodes, facets or cells the user's text means."""

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SelectionError
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.entities import all_entities, corner_nodes
from fenics_defo.fem.imported import EntityGroup, MeshData, MeshRecord, mesh_record
from fenics_defo.fem.input_order import node_rows
from fenics_defo.fem.nodes import NodeNumbering
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.fem.selection import (
    ComparisonSelection,
    GroupSelection,
    NodeFileSelection,
    equality_tolerance,
    parse_selection,
)

_KINDS = {0: "vertex", 1: "edge", 2: "facet", 3: "volume"}
_PLURALS = {0: "vertices", 1: "edges", 2: "facets", 3: "volumes"}


def select_nodes(
    mesh_data: MeshData,
    space: "dolfinx.fem.FunctionSpace",
    numbering: NodeNumbering,
    selection: str | int,
) -> NDArray[np.bool_]:
    """Nodes of a displacement space that a selection means.

    A group means all nodes of its entities (of groups that share a name or a number, the facets
    before the cells); a comparison the nodes whose coordinates fulfil it; a
    node file, or a group of nodes, the nodes it names and, where order 2 has put nodes between the
    file's, those between named corners only. Collective.

    Args:
        mesh_data: mesh.
        space: displacement space on it.
        numbering: its node numbering.
        selection: group name or number, comparison of coordinates, or ``nodes:FILE``.

    Returns:
        (n,) true at selected nodes, the same on each rank.

    Raises:
        SelectionError: not well formed, no such group, or no node selected.
    """
    record = mesh_record(mesh_data)
    parsed = parse_selection(selection, groups={group.name for group in record.groups})
    chosen = np.zeros(numbering.size, bool)
    match parsed:
        case GroupSelection(group):
            for found in _on_surface(_named(record.groups, group)):
                chosen |= _nodes_of_group(found, space, numbering)
        case ComparisonSelection():
            chosen |= parsed.evaluate(numbering.points, _tolerance(numbering.points))
        case NodeFileSelection():
            rows = np.flatnonzero(
                np.isin(record.node_numbers, _numbers(space.mesh, parsed, record))
            )
            chosen |= _with_nodes_between(rows, numbering)
    chosen &= numbering.carried
    if not chosen.any():
        raise _nothing(selection, numbering.points, record.groups, "node")
    return chosen


def select_entities(
    mesh_data: MeshData, selection: str | int, *, dimension: int
) -> NDArray[np.int32]:
    """Vertices, boundary facets or cells of a mesh that a selection means.

    A group gives its own entities of that dimension; one of nodes only, the boundary facets all of
    whose corners it names. A comparison gives vertices and boundary
    facets all of whose corners fulfil it, and cells whose midpoint does; a node file, entities all
    of whose corners it names. Collective.

    Args:
        mesh_data: mesh.
        selection: group name or number, comparison of coordinates, or ``nodes:FILE``.
        dimension: 0 vertices, 1 edges, 2 facets, 3 cells.

    Returns:
        (k,) this rank's entities, ascending.

    Raises:
        SelectionError: not well formed, no such group, or nothing selected on any rank.
    """
    mesh, record = mesh_data.mesh, mesh_record(mesh_data)
    parsed = parse_selection(selection, groups={group.name for group in record.groups})
    match parsed:
        case GroupSelection(group):
            named = _named(record.groups, group)
            parts = [g.entities for g in named if g.dimension == dimension]
            if dimension == 2 and not parts:
                parts = [_facets_between(mesh, g.nodes) for g in named if g.nodes is not None]
            found = np.unique(np.concatenate([np.empty(0, np.int32), *parts]))
        case ComparisonSelection():
            entities, corners = _candidates(mesh, dimension)
            x, tolerance = mesh.geometry.x, _tolerance(_corners_of_box(mesh))
            if dimension == 3:
                found = entities[parsed.evaluate(x[corners].mean(axis=1), tolerance)]
            else:
                found = entities[parsed.evaluate(x, tolerance)[corners].all(axis=1)]
        case NodeFileSelection():
            entities, corners = _candidates(mesh, dimension)
            listed = np.isin(record.node_numbers, _numbers(mesh, parsed, record))
            found = entities[listed[node_rows(mesh)][corners].all(axis=1)]
    if mesh.comm.allreduce(int(found.size)) == 0:
        raise _nothing(selection, _corners_of_box(mesh), record.groups, _KINDS[dimension])
    return found.astype(np.int32)


def select_facets(mesh_data: MeshData, selection: str | int) -> NDArray[np.int32]:
    """Facets of the surface that a selection means, as by `select_entities`; collective.

    Returns:
        (k,) this rank's own facets, ascending.

    Raises:
        SelectionError: not well formed, no such group, or nothing of the surface selected.
    """
    mesh = mesh_data.mesh
    found = select_entities(mesh_data, selection, dimension=2)
    mesh.topology.create_connectivity(2, 3)
    chosen = np.intersect1d(found, dolfinx.mesh.exterior_facet_indices(mesh.topology))
    if mesh.comm.allreduce(int(chosen.size)) == 0:
        raise SelectionError(
            f"all facets of the selection {selection!r} lie inside the body, where no load can act "
            "on them; select facets of its surface"
        )
    return chosen.astype(np.int32)


def describe_groups(groups: Sequence[EntityGroup]) -> str:
    """The groups of a mesh in one phrase, for messages."""
    if not groups:
        return "no groups at all"
    shown = [
        f"{g.name!r} ({g.number}, {g.size} {(_KINDS if g.size == 1 else _PLURALS)[g.dimension]})"
        for g in groups[:20]
    ]
    more = f" and {len(groups) - 20} more" if len(groups) > 20 else ""
    return ", ".join(shown) + more


def _nodes_of_group(
    group: EntityGroup, space: "dolfinx.fem.FunctionSpace", numbering: NodeNumbering
) -> NDArray[np.bool_]:
    if group.nodes is not None:
        return _with_nodes_between(group.nodes, numbering)
    space.mesh.topology.create_connectivity(group.dimension, 3)
    dofs = dolfinx.fem.locate_dofs_topological(space, group.dimension, group.entities)
    chosen = np.zeros(numbering.size, bool)
    chosen[numbering.rows[dofs]] = True
    space.mesh.comm.Allreduce(MPI.IN_PLACE, chosen, op=MPI.LOR)
    return chosen


def _with_nodes_between(rows: NDArray[np.int64], numbering: NodeNumbering) -> NDArray[np.bool_]:
    """(n,) the file's nodes in ``rows`` and the appended nodes between those that are corners."""
    chosen = np.zeros(numbering.size, bool)
    chosen[rows] = True
    if numbering.size > numbering.file_nodes:
        appended = np.arange(numbering.size) >= numbering.file_nodes
        outside = numbering.corner_weights @ (~chosen).astype(float)
        chosen |= appended & (outside == 0.0)
    return chosen


def _candidates(
    mesh: "dolfinx.mesh.Mesh", dimension: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """All cells, boundary facets, edges or vertices of this rank, and their corners (k, v)."""
    entities = all_entities(mesh, dimension)
    if dimension == 2:
        mesh.topology.create_connectivity(2, 3)
        entities = np.sort(dolfinx.mesh.exterior_facet_indices(mesh.topology))
    return entities, corner_nodes(mesh, dimension, entities)


def _facets_between(mesh: "dolfinx.mesh.Mesh", rows: NDArray[np.int64]) -> NDArray[np.int32]:
    """Boundary facets all of whose corners are among the file's nodes ``rows``."""
    facets, corners = _candidates(mesh, 2)
    return facets[np.isin(node_rows(mesh), rows)[corners].all(axis=1)]


def _corners_of_box(mesh: "dolfinx.mesh.Mesh") -> NDArray[np.float64]:
    """(2, 3) smallest and largest coordinates of the nodes on all ranks."""
    x = mesh.geometry.x
    low = np.min(x, axis=0, initial=np.inf)
    high = np.max(x, axis=0, initial=-np.inf)
    mesh.comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    mesh.comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return np.array([low, high])


def _tolerance(points: NDArray[np.float64]) -> float:
    return equality_tolerance(points.min(axis=0), points.max(axis=0))


def _named(groups: Sequence[EntityGroup], wanted: str | int) -> list[EntityGroup]:
    found = [g for g in groups if wanted == (g.number if isinstance(wanted, int) else g.name)]
    if not found:
        other = "Select one of them, a" if groups else "Select by a"
        raise SelectionError(
            f"the mesh has no group {wanted!r}; it has {describe_groups(groups)}. "
            f"{other} comparison such as 'x<1e-6', or 'nodes:FILE'"
        )
    return found


def _on_surface(groups: list[EntityGroup]) -> list[EntityGroup]:
    """Of groups that share a name or a number, the facets; else edges, points, cells.

    Gmsh numbers the groups of each dimension anew: a constraint on "1" hardly means the volume.
    """
    best = max(groups, key=lambda group: group.dimension if group.dimension < 3 else -1).dimension
    return [group for group in groups if group.dimension == best]


def _numbers(
    mesh: "dolfinx.mesh.Mesh", selection: NodeFileSelection, record: MeshRecord
) -> NDArray[np.int64]:
    """Content of the node file, which rank 0 reads, checked against the mesh; collective."""
    wanted = on_first_rank(mesh.comm, selection.read)
    unknown = np.setdiff1d(wanted, record.node_numbers)
    if unknown.size:
        others = f" nor {unknown.size - 1} others of the list" if unknown.size > 1 else ""
        raise SelectionError(
            f"{selection.path}: the mesh has no node {unknown[0]}{others}; its nodes are numbered "
            f"{record.node_numbers.min()} to {record.node_numbers.max()}"
        )
    return wanted


def _nothing(
    selection: str | int, points: NDArray[np.float64], groups: Sequence[EntityGroup], kind: str
) -> SelectionError:
    low, high = points.min(axis=0), points.max(axis=0)
    box = ", ".join(f"{a:.6g} <= {c} <= {b:.6g}" for c, a, b in zip("xyz", low, high, strict=True))
    return SelectionError(
        f"the selection {selection!r} matches no {kind}; the mesh lies in {box} (m) "
        f"and has {describe_groups(groups)}"
    )
