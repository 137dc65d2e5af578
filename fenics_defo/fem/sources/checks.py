"""From a raw mesh to a `SourceMesh`: each fault is refused or mended, and each mending noted.

The order matters: rows are checked before they are used as indices, coordinates before anything is
measured, seams are closed before pieces are counted, and groups come last because nodes and cells
have their final numbers then.
"""

from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.draft import Draft, begin_draft, complete_serendipity, spot
from fenics_defo.fem.sources.memberships import settle_groups
from fenics_defo.fem.sources.numbering import row_keys
from fenics_defo.fem.sources.orientation import orient
from fenics_defo.fem.sources.raw_mesh import RawMesh
from fenics_defo.fem.sources.seams import treat_coincident_nodes
from fenics_defo.fem.sources.source_mesh import SourceMesh


def checked(raw: RawMesh, *, merge: float | None = None, path: Path | None = None) -> SourceMesh:
    """Check a raw mesh and freeze it.

    Args:
        raw: content of a file.
        merge: distance [m] below which nodes are made one; None leaves them and notes them.
        path: the file.

    Raises:
        MeshError: a fault that cannot be mended; the sentence says which, where and what to do.
    """
    draft = begin_draft(raw)
    drop_unused_nodes(draft)
    require_finite(draft)
    require_distinct_nodes(draft)
    drop_duplicate_cells(draft)
    complete_serendipity(draft)
    treat_coincident_nodes(draft, merge=merge)
    if merge is not None:
        drop_duplicate_cells(draft)
    orient(draft)
    groups = settle_groups(draft)
    note_pieces(draft)
    for array in (draft.points, draft.cells, draft.node_numbers, draft.cell_numbers):
        array.setflags(write=False)
    return SourceMesh(
        points=draft.points,
        cells=draft.cells,
        kind=draft.shape.kind,
        order=draft.shape.order,
        node_numbers=draft.node_numbers,
        cell_numbers=draft.cell_numbers,
        groups=groups,
        materials=tuple(raw.materials),
        notes=tuple(draft.notes),
        path=path,
    )


def drop_unused_nodes(draft: Draft) -> None:
    """Drop nodes of no volume cell: they would be free dofs without stiffness or mass."""
    before = len(draft.points)
    draft.replace_nodes(np.arange(before))
    if dropped := before - len(draft.points):
        draft.notes.append(
            f"{dropped} of {before} nodes belong to no volume cell and were dropped."
        )


def require_finite(draft: Draft) -> None:
    """Refuse coordinates that are not numbers."""
    bad = ~np.isfinite(draft.points).all(axis=1)
    if np.any(bad):
        first = int(np.flatnonzero(bad)[0])
        raise MeshError(
            f"{draft.label}: {np.count_nonzero(bad)} nodes have coordinates that are not finite, "
            f"first node {draft.node_numbers[first]} with {spot(draft.points[first])}; "
            "mend the file"
        )


def require_distinct_nodes(draft: Draft) -> None:
    """Refuse cells that name a node twice."""
    ordered = np.sort(draft.cells, axis=1)
    bad = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if np.any(bad):
        first = int(np.flatnonzero(bad)[0])
        raise MeshError(
            f"{draft.label}: {np.count_nonzero(bad)} cells name the same node twice (collapsed "
            f"cells, wedges written as hexahedra), first {draft.place(first)}; "
            "re-mesh with whole cells"
        )


def drop_duplicate_cells(draft: Draft) -> None:
    """Keep one of several cells on the same nodes; together they would count the body twice.

    Format 2 of Gmsh writes a cell once for each physical group it belongs to.
    """
    (keys,) = row_keys(draft.corners)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    if extra := len(keys) - len(first):
        draft.replace_cells(first[inverse])
        draft.replace_nodes(np.arange(len(draft.points)))
        draft.notes.append(
            f"{extra} cells repeat the nodes of an earlier cell and were dropped "
            "(their groups are kept on the earlier one)."
        )


def note_pieces(draft: Draft) -> None:
    """Note a body of several pieces that share no node."""
    m, c = draft.corners.shape
    rows = np.repeat(np.arange(m), c)
    columns = m + draft.corners.ravel()
    graph = coo_array(
        (np.ones(m * c, dtype=np.int8), (rows, columns)), shape=(m + len(draft.points),) * 2
    )
    labels = connected_components(graph.tocsr(), directed=False)[1][:m]
    sizes = np.unique(labels, return_counts=True)[1]
    if len(sizes) > 1:
        draft.notes.append(
            f"the mesh falls into {len(sizes)} pieces that share no node (largest "
            f"{sizes.max()} cells, smallest {sizes.min()}); each free piece has six rigid modes."
        )
