"""Nodes at the same place: a seam that leaves the cells on its two sides unconnected."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.draft import Draft, spot

COINCIDENT = 1e-9  # of the diagonal of the bounding box: above round-off, far below a cell


def treat_coincident_nodes(draft: Draft, *, merge: float | None) -> None:
    """Merge nodes nearer than ``merge`` [m], or note coincident ones when it is None.

    Raises:
        MeshError: ``merge`` is not positive, or reaches the shortest edge (whole cells would
            collapse).
    """
    diagonal = float(np.linalg.norm(np.ptp(draft.points, axis=0)))
    if merge is not None:
        check_merge(draft, merge)
    distance = COINCIDENT * diagonal if merge is None else merge
    pairs = KDTree(draft.points).query_pairs(distance, output_type="ndarray")
    if len(pairs) == 0:
        if merge is not None:
            draft.notes.append(f"no two nodes lie within merge = {merge:g} of each other.")
        return
    if merge is None:
        shown = spot(draft.points[pairs[0, 0]])
        draft.notes.append(
            f"{len(np.unique(pairs))} nodes share their place with another, for example at "
            f"{shown}: a possible seam across which the body is not connected; "
            f"--merge {10 * distance:.1g} (merge=) would join them."
        )
        return
    n = len(draft.points)
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), pairs.T), shape=(n, n))
    labels = connected_components(graph.tocsr(), directed=False)[1]
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    draft.replace_nodes(first[inverse])
    draft.notes.append(
        f"{n - len(draft.points)} nodes were merged into an earlier one within {merge:g} of them."
    )
    _require_whole(draft, merge)


def check_merge(draft: Draft, merge: float) -> None:
    """Refuse a merging distance that is not positive or not below the shortest edge."""
    ends = np.array(draft.shape.edges)
    x = draft.points
    shortest = min(
        np.linalg.norm(x[draft.cells[:, a]] - x[draft.cells[:, b]], axis=1).min() for a, b in ends
    )
    shortest /= draft.shape.order  # mid nodes halve the edges
    if not 0.0 < merge < shortest:
        raise MeshError(
            f"{draft.label}: the merging distance is {merge!r}; --merge (merge=) must be positive "
            f"and below {shortest:.6g}, the shortest distance of two nodes along an edge"
        )


def _require_whole(draft: Draft, merge: float) -> None:
    ordered = np.sort(draft.cells, axis=1)
    bad = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if np.any(bad):
        first = int(np.flatnonzero(bad)[0])
        raise MeshError(
            f"{draft.label}: merging nodes within {merge:g} collapses {np.count_nonzero(bad)} "
            f"cells, first {draft.place(first)}; give a smaller --merge (merge=)"
        )
