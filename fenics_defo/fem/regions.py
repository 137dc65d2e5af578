"""Selections resolved on a mesh: which nodes, facets or cells the user's text means."""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from fenics_defo.errors import SelectionError
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.imported import EntityGroup, MeshData, mesh_record
from fenics_defo.fem.nodes import NodeNumbering
from fenics_defo.fem.selection import (
    ComparisonSelection,
    GroupSelection,
    NodeFileSelection,
    equality_tolerance,
    parse_selection,
)

_KINDS = {0: "vertex", 1: "edge", 2: "facet", 3: "volume"}


def select_nodes(
    mesh_data: MeshData,
    space: "dolfinx.fem.FunctionSpace",
    numbering: NodeNumbering,
    selection: str | int,
) -> NDArray[np.bool_]:
    """Nodes of a displacement space that a selection means.

    A group means all nodes of its entities; a comparison the nodes whose coordinates fulfil it; a node file the
    nodes it names and, where order 2 has put nodes between the file's, those between named corners only.
    Collective.

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
    match parsed:
        case GroupSelection(group):
            chosen = np.zeros(numbering.size, bool)
            for found in _named(record.groups, group):
                space.mesh.topology.create_connectivity(found.dimension, 3)
                dofs = dolfinx.fem.locate_dofs_topological(space, found.dimension, found.entities)
                chosen[numbering.rows[dofs]] = True
            space.mesh.comm.Allreduce(MPI.IN_PLACE, chosen, op=MPI.LOR)
        case ComparisonSelection():
            chosen = parsed.evaluate(numbering.points, _tolerance(numbering.points))
            chosen &= numbering.carried
        case NodeFileSelection():
            chosen = _numbered_nodes(parsed, record.node_numbers, numbering)
    if not chosen.any():
        raise _nothing(selection, numbering.points, record.groups, "node")
    return chosen


def select_entities(
    mesh_data: MeshData, selection: str | int, *, dimension: int
) -> NDArray[np.int32]:
    """Vertices, boundary facets or cells of a mesh that a selection means.

    A group gives its own entities of that dimension. A comparison gives vertices and boundary facets all of whose
    corners fulfil it, and cells whose midpoint does; a node file, entities all of whose corners it names.
    Collective.

    Args:
        mesh_data: mesh.
        selection: group name or number, comparison of coordinates, or ``nodes:FILE``.
        dimension: 0 vertices, 2 facets, 3 cells.

    Returns:
        (k,) this rank's entities, ghosts included, ascending.

    Raises:
        SelectionError: not well formed, no such group, or nothing selected on any rank.
    """
    mesh, record = mesh_data.mesh, mesh_record(mesh_data)
    parsed = parse_selection(selection, groups={group.name for group in record.groups})
    if isinstance(parsed, GroupSelection):
        groups = [g for g in _named(record.groups, parsed.group) if g.dimension == dimension]
        found = np.unique(np.concatenate([g.entities for g in groups] or [np.empty(0, np.int32)]))
    else:
        entities = _candidates(mesh, dimension)
        corners = dolfinx.mesh.entities_to_geometry(mesh, dimension, entities)
        x = mesh.geometry.x
        if isinstance(parsed, NodeFileSelection):
            numbers = record.node_numbers[mesh.geometry.input_global_indices]
            inside = np.isin(numbers, parsed.read())[corners].all(axis=1)
        else:
            tolerance = _tolerance(*_corners_of_box(mesh))
            inside = (
                parsed.evaluate(x[corners].mean(axis=1), tolerance)
                if dimension == 3
                else parsed.evaluate(x, tolerance)[corners].all(axis=1)
            )
        found = entities[inside]
    if mesh.comm.allreduce(found.size) == 0:
        points = np.vstack(_corners_of_box(mesh))
        raise _nothing(selection, points, record.groups, _KINDS[dimension])
    return found.astype(np.int32)


def _candidates(mesh: "dolfinx.mesh.Mesh", dimension: int) -> NDArray[np.int32]:
    mesh.topology.create_entities(dimension)
    mesh.topology.create_connectivity(dimension, 3)
    if dimension == 2:
        mesh.topology.create_connectivity(2, 3)
        return np.sort(dolfinx.mesh.exterior_facet_indices(mesh.topology))
    index_map = mesh.topology.index_map(dimension)
    return np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)


def _corners_of_box(mesh: "dolfinx.mesh.Mesh") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    x = mesh.geometry.x
    low = np.min(x, axis=0) if len(x) else np.full(3, np.inf)
    high = np.max(x, axis=0) if len(x) else np.full(3, -np.inf)
    mesh.comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    mesh.comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return low, high


def _tolerance(*points: NDArray[np.float64]) -> float:
    every = np.vstack(points)
    return equality_tolerance(every.min(axis=0), every.max(axis=0))


def _named(groups: Sequence[EntityGroup], wanted: str | int) -> list[EntityGroup]:
    found = [g for g in groups if wanted in ((g.number,) if isinstance(wanted, int) else (g.name,))]
    if not found:
        raise SelectionError(
            f"the mesh has no group {wanted!r}; it has {describe_groups(groups)}. "
            "Select one of them, a comparison such as 'x<1e-6', or 'nodes:FILE'"
        )
    return found


def describe_groups(groups: Sequence[EntityGroup]) -> str:
    """The groups of a mesh in one phrase, for messages."""
    if not groups:
        return "no groups at all"
    shown = [f"{g.name!r} ({g.number}, {g.size} {_KINDS[g.dimension]}s)" for g in groups[:20]]
    more = f" and {len(groups) - 20} more" if len(groups) > 20 else ""
    return ", ".join(shown).replace("vertexs", "vertices") + more


def _numbered_nodes(
    selection: NodeFileSelection, node_numbers: NDArray[np.int64], numbering: NodeNumbering
) -> NDArray[np.bool_]:
    wanted = selection.read()
    unknown = np.setdiff1d(wanted, node_numbers)
    if unknown.size:
        raise SelectionError(
            f"{selection.path}: the mesh has no node {unknown[0]}"
            f"{'' if unknown.size == 1 else f' nor {unknown.size - 1} others of the list'}; "
            f"its nodes are numbered {node_numbers.min()} to {node_numbers.max()}"
        )
    chosen = np.zeros(numbering.size, bool)
    chosen[: len(node_numbers)] = np.isin(node_numbers, wanted)
    appended = np.arange(numbering.size) >= len(node_numbers)
    outside = numbering.corner_weights @ (~chosen).astype(float)
    return (chosen | (appended & (outside == 0.0))) & numbering.carried


def _nothing(
    selection: str | int, points: NDArray[np.float64], groups: Sequence[EntityGroup], kind: str
) -> SelectionError:
    low, high = points.min(axis=0), points.max(axis=0)
    box = ", ".join(f"{a:.6g} <= {c} <= {b:.6g}" for c, a, b in zip("xyz", low, high, strict=True))
    return SelectionError(
        f"the selection {selection!r} matches no {kind}; the mesh lies in {box} (m) "
        f"and has {describe_groups(groups)}"
    )
