"""Closed surfaces: welding, holes, orientation, and which shell lies inside which."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.draft import spot
from fenics_defo.fem.sources.numbering import row_keys

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
SAMPLE = 2e7  # pairs of point and triangle looked at when solids are tested for overlap
WELD = 1e-7  # of the diagonal: .stl stores single precision, so equal corners may differ by this


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedSurface:
    """A closed surface in shells.

    Args:
        points: (n, 3) welded points [m].
        triangles: (t, 3) rows, anticlockwise seen from outside their shell.
        shell: (t,) number of the shell of each triangle, from 0.
        solids: for each solid body the shells that bound it: the outer one, then its cavities.
        volume: of all solid bodies [m³].
        notes: what was mended.
    """

    points: Floats
    triangles: Integers
    shell: Integers
    solids: tuple[tuple[int, ...], ...]
    volume: float
    notes: tuple[str, ...]


def close_surface(points: Floats, triangles: Integers, path: Path) -> ClosedSurface:
    """Weld, check and orient a surface.

    Raises:
        MeshError: open, branching or one-sided, with the number and place of the faults.
    """
    points, triangles, notes = _weld(points, triangles, path)
    first, second = _edge_pairs(points, triangles, path)
    shell, triangles = _orient(triangles, first, second, path)
    volumes = _volumes(points, triangles, shell)
    flat = ~(np.abs(volumes) > 0.0)
    if np.any(flat):
        raise MeshError(
            f"{path}: {np.count_nonzero(flat)} closed parts enclose no volume; "
            "remove them or export the surface again"
        )
    inward = volumes < 0.0
    turned = inward[shell]
    triangles[turned] = triangles[turned][:, ::-1]
    volumes = np.abs(volumes)
    solids = _solids(points, triangles, shell, volumes)
    cavities = sum(len(solid) - 1 for solid in solids)
    if cavities:
        notes.append(f"{cavities} shells lie inside a body and were taken for cavities in it.")
    volume = sum(volumes[s[0]] - volumes[list(s[1:])].sum() for s in solids)
    return ClosedSurface(
        points=points,
        triangles=triangles,
        shell=shell,
        solids=solids,
        volume=float(volume),
        notes=tuple(notes),
    )


def _weld(points: Floats, triangles: Integers, path: Path) -> tuple[Floats, Integers, list[str]]:
    used = np.unique(triangles)
    x = points[used]
    rows = np.searchsorted(used, triangles)
    diagonal = float(np.linalg.norm(np.ptp(x, axis=0)))
    pairs = KDTree(x).query_pairs(WELD * diagonal, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), pairs.T), shape=(len(x),) * 2)
    labels = connected_components(graph.tocsr(), directed=False)[1]
    _, keep, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rows = inverse[rows]
    ordered = np.sort(rows, axis=1)
    whole = (ordered[:, 1:] != ordered[:, :-1]).all(axis=1)
    rows = rows[whole]
    if len(rows) == 0:
        raise MeshError(f"{path}: every triangle is flat; export the surface again")
    (keys,) = row_keys(rows)
    _, first = np.unique(keys, return_index=True)
    notes = []
    if dropped := len(triangles) - len(first):
        notes.append(f"{dropped} triangles of no area or given twice were dropped.")
    return x[keep], rows[np.sort(first)], notes


def _edge_pairs(points: Floats, triangles: Integers, path: Path) -> tuple[Integers, Integers]:
    """Half edges that meet: half edge h belongs to triangle h // 3; (e,) and (e,)."""
    half = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    (keys,) = row_keys(half)
    order = np.argsort(keys, kind="stable")
    _, start, count = np.unique(keys[order], return_index=True, return_counts=True)
    for wrong, what, remedy in (
        (count == 1, "open: it has {} boundary edges", "close the hole"),
        (count > 2, "branching: {} edges join more than two triangles", "separate the parts"),
    ):
        if np.any(wrong):
            a, b = points[half[order[start[np.flatnonzero(wrong)[0]]]]]
            raise MeshError(
                f"{path}: the surface is {what.format(np.count_nonzero(wrong))}, the first from "
                f"{spot(a)} to {spot(b)}; {remedy} (a mesh editor's repair function) and try again"
            )
    return order[start], order[start + 1]


def _orient(
    triangles: Integers, first: Integers, second: Integers, path: Path
) -> tuple[Integers, Integers]:
    """Shell of each triangle, and the triangles with neighbours turned alike.

    In the double cover every triangle occurs as it is and turned; two occurrences are joined when
    they agree across an edge. An orientable shell gives two components, mirror images.
    """
    half = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    agree = half[first, 0] == half[second, 1]
    a, b, t = first // 3, second // 3, len(triangles)
    other = np.where(agree, b, b + t)
    mirror = np.where(agree, b + t, b)
    rows, columns = np.concatenate([a, a + t]), np.concatenate([other, mirror])
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * t,) * 2)
    cover = connected_components(graph.tocsr(), directed=False)[1]
    if np.any(cover[:t] == cover[t:]):
        raise MeshError(f"{path}: the surface has one side only; export a closed surface")
    # Of the two mirror images, take the one with the lower label.
    shell = np.unique(np.minimum(cover[:t], cover[t:]), return_inverse=True)[1]
    turned = cover[:t] > cover[t:]
    result = triangles.copy()
    result[turned] = result[turned][:, ::-1]
    return shell, result


def _volumes(points: Floats, triangles: Integers, shell: Integers) -> Floats:
    """Signed enclosed volume of each shell, by the divergence theorem."""
    a, b, c = np.moveaxis(points[triangles] - points.mean(axis=0), 1, 0)
    return np.bincount(shell, weights=np.einsum("ti,ti->t", a, np.cross(b, c)) / 6.0)


def _solids(
    points: Floats, triangles: Integers, shell: Integers, volumes: Floats
) -> tuple[tuple[int, ...], ...]:
    """Shells at even depth bound solids from outside, shells at odd depth are their cavities."""
    count = len(volumes)
    inside = np.zeros((count, count), dtype=bool)  # inside[i, j]: shell i lies in shell j
    seeds = points[triangles[np.unique(shell, return_index=True)[1], 0]]
    for j in range(count if count > 1 else 0):
        corners = points[triangles[shell == j]]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        near = ((seeds > low) & (seeds < high)).all(axis=1) & (volumes < volumes[j])
        for i in np.flatnonzero(near):
            inside[i, j] = _winding(seeds[i], corners) > 0.5
    depth = inside.sum(axis=1)
    solids = []
    for outer in np.flatnonzero(depth % 2 == 0).tolist():
        cavities = np.flatnonzero(inside[:, outer] & (depth == depth[outer] + 1))
        solids.append((outer, *cavities.tolist()))
    return tuple(solids)


def _winding(seed: Floats, corners: Floats) -> float:
    """Winding number of outward triangles (t, 3, 3) about a point: 1 inside, 0 outside.

    Sum of signed solid angles, tan(Ω/2) = a.(b x c) / (abc + (a.b)c + (b.c)a + (c.a)b)
    (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983).
    """
    a, b, c = np.moveaxis(corners - seed, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = np.einsum("ti,ti->t", a, np.cross(b, c))
    dot = np.einsum
    bottom = la * lb * lc
    bottom += dot("ti,ti->t", a, b) * lc + dot("ti,ti->t", b, c) * la + dot("ti,ti->t", c, a) * lb
    return float(np.arctan2(top, bottom).sum() / (2.0 * np.pi))


def overlap(surface: ClosedSurface, points: Floats) -> Floats | None:
    """One of ``points``, all of them inside a solid, that lies in two solids at once; or None.

    Looks only where the boxes of solids overlap, and at a sample of the points there.
    """
    outer = [solid[0] for solid in surface.solids]
    if len(outer) < 2:
        return None
    shared = np.zeros(len(points), dtype=np.int64)
    for shell in outer:
        corners = surface.points[surface.triangles[surface.shell == shell]]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        shared += ((points > low) & (points < high)).all(axis=1)
    candidates = points[shared > 1]
    sign = np.full(1 + int(surface.shell.max()), -1.0)
    sign[outer] = 1.0
    corners = surface.points[surface.triangles]
    inward = sign[surface.shell] < 0.0
    corners[inward] = corners[inward][:, ::-1]
    sample = int(np.clip(SAMPLE / len(corners), 50, 500))
    for point in candidates[:: 1 + len(candidates) // sample]:
        if _winding(point, corners) > 1.5:
            return point
    return None


def refine(points: Floats, triangles: Integers) -> tuple[Floats, Integers]:
    """The same surface with each triangle cut into four at the middles of its edges."""
    half = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    (keys,) = row_keys(half)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    middles = 0.5 * points[half[first]].sum(axis=1)
    ab, bc, ca = (len(points) + inverse.reshape(-1, 3)).T
    a, b, c = triangles.T
    parts = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1)
    return np.concatenate([points, middles]), parts.reshape(-1, 3)
