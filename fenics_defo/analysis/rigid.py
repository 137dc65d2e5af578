"""Motions of a body that strain no cell: rigid motions of its parts, and what hinges allow."""

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse import csgraph

_log = logging.getLogger(__name__)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# Corners of the faces, by the number of a cell's corners.
_FACES = {
    4: np.array([(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]),
    8: np.array(
        [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    ),
}
# A lever shorter than this part of the body's size holds no rotation.
_LEVER = 1e-6
# Blocks that hang together by nodes or edges only are analysed up to this number.
_BLOCKS = 100


def rigid_motions(points: Array, centre: Array) -> Array:
    """Unit translations along and small rotations about the axes through a point.

    Args:
        points: (n, 3) [m].
        centre: (3,) [m].

    Returns:
        (6, n, 3): x, y, z [-], then rx, ry, rz [m per radian].
    """
    arm = points - centre
    motions = np.zeros((6, *points.shape))
    for axis in range(3):
        motions[axis, :, axis] = 1.0
        motions[3 + axis] = np.cross(np.eye(3)[axis], arm)
    return motions


def blocks(corners: Ints) -> tuple[int, Ints]:
    """Parts of a mesh whose cells hang together by faces: such a part moves rigidly as a whole.

    Args:
        corners: (m, 4 or 8) node rows of the cells' corners, in VTK's order.

    Returns:
        number of parts, and the part of each cell (m,).
    """
    faces = _FACES[corners.shape[1]]
    keys = _face_keys(corners[:, faces].reshape(-1, faces.shape[1]))
    order = np.argsort(keys)
    same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    one, other = order[same] // len(faces), order[same + 1] // len(faces)
    shape = (len(corners), len(corners))
    links = sparse.coo_array((np.ones(len(one), np.int8), (one, other)), shape=shape)
    number, labels = csgraph.connected_components(links, directed=False)
    return int(number), labels.astype(np.int64)


def _face_keys(faces: Ints) -> Ints:
    """One number for each face (f, 3 or 4) that tells it from others, whatever its corners' order.

    The sum, modulo 2⁶⁴, of one random number for each corner: of a million faces some two get the
    same by chance with a probability of 3e-8. Five times faster than sorting the corners.
    """
    marks = np.random.default_rng(0).integers(-(2**63), 2**63, int(faces.max()) + 1)
    keys = marks[faces[:, 0]]
    for corner in faces.T[1:]:
        keys += marks[corner]
    return keys


def strainless_motions(points: Array, cells: Ints, corners: int, held: NDArray[np.bool_]) -> Array:
    """Independent displacement fields that strain no cell and respect the held components.

    These are the null space of the stiffness at rest: rigid motions of parts that share no node,
    less what the constraints take; and the rotations about a node or an edge by which alone two
    blocks of cells hang together.

    Args:
        points: (n, 3) [m].
        cells: (m, c) node rows, corners first, in VTK's order.
        corners: number of a cell's corners, 4 or 8.
        held: (n, 3) true where a displacement component is zero.

    Returns:
        (k, n, 3) fields of order one, zero at held components.
    """
    number, of_cell = blocks(cells[:, :corners])
    members = _members(number, of_cell, cells, len(points))
    fields = [np.zeros((0, *points.shape))]
    for group in _groups(number, members):
        fields.append(_null_space(group, points, held))
    every = np.concatenate(fields)
    every[:, held] = 0.0
    return every


@dataclass(frozen=True, slots=True)
class _Group:
    """Blocks that hang together by nodes: pairs of a block and a node of it, nodes ascending.

    Args:
        size: number of blocks.
        block: (p,) from 0 to size - 1.
        node: (p,) rows of the points.
    """

    size: int
    block: Ints
    node: Ints


def _members(number: int, of_cell: Ints, cells: Ints, count: int) -> tuple[Ints, Ints]:
    """Pairs of a block and a node, by node, then by block."""
    if number == 1:
        nodes = np.unique(cells)
        return np.zeros(len(nodes), np.int64), nodes
    pairs = np.unique(cells.astype(np.int64) * number + of_cell[:, None])
    node, block = np.divmod(pairs, number)
    return block, node


def _groups(number: int, members: tuple[Ints, Ints]) -> Iterator[_Group]:
    block, node = members
    if number == 1:
        yield _Group(1, block, node)
        return
    shared = node[1:] == node[:-1]
    ends = block[:-1][shared], block[1:][shared]
    links = sparse.coo_array((np.ones(len(ends[0]), np.int8), ends), shape=(number, number))
    count, of_block = csgraph.connected_components(links, directed=False)
    order = np.argsort(of_block[block], kind="stable")
    starts = np.searchsorted(of_block[block][order], np.arange(count + 1))
    for start, stop in pairwise(starts):
        here = order[start:stop]
        names, own = np.unique(block[here], return_inverse=True)
        size = len(names)
        if size > 1:
            _log.warning(
                "%d blocks of cells hang together by single nodes or edges only, as by hinges", size
            )
        if size > _BLOCKS:  # too many for a dense null space: as if it were one solid part
            size, own = 1, np.zeros(len(here), np.int64)
        yield _Group(size, own.reshape(-1).astype(np.int64), node[here])


def _null_space(group: _Group, points: Array, held: NDArray[np.bool_]) -> Array:
    """Motions (k, n, 3) of a group that its joints and the held components allow."""
    at = points[group.node]
    centre = 0.5 * (at.min(axis=0) + at.max(axis=0))
    size = max(float(np.abs(at - centre).max()), np.finfo(float).tiny)
    motions = rigid_motions((at - centre) / size, np.zeros(3))
    rows = np.vstack([_joints(group, motions), _holds(group, motions, held)])
    if not len(rows):
        rows = np.zeros((1, 6 * group.size))
    triangle = linalg.qr(rows, mode="r")[0][: rows.shape[1]]
    _, singular, right = linalg.svd(triangle)
    rank = int(np.count_nonzero(singular > _LEVER * np.sqrt(len(rows))))
    fields = np.zeros((len(right) - rank, *points.shape))
    for field, coefficients in zip(fields, right[rank:].reshape(-1, group.size, 6), strict=True):
        # A node of several blocks gets the same displacement from each.
        field[group.node] = np.einsum("pi,ipc->pc", coefficients[group.block], motions)
    return fields


def _joints(group: _Group, motions: Array) -> Array:
    """Rows (3 j, 6 size): at a shared node two blocks move alike."""
    second = np.flatnonzero(group.node[1:] == group.node[:-1]) + 1
    second = second[group.block[second] != group.block[second - 1]]
    rows = np.zeros((len(second), 3, group.size, 6))
    joint = np.arange(len(second))
    rows[joint, :, group.block[second]] = motions[:, second].transpose(1, 2, 0)
    rows[joint, :, group.block[second - 1]] = -motions[:, second - 1].transpose(1, 2, 0)
    return rows.reshape(-1, 6 * group.size)


def _holds(group: _Group, motions: Array, held: NDArray[np.bool_]) -> Array:
    """Rows (h, 6 size): a held component does not move."""
    first = np.concatenate([[True], group.node[1:] != group.node[:-1]])
    place, component = np.nonzero(held[group.node] & first[:, None])
    rows = np.zeros((len(place), group.size, 6))
    rows[np.arange(len(place)), group.block[place]] = motions[:, place, component].T
    return rows.reshape(-1, 6 * group.size)


def supports(fields: Array, free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """As many components as there are fields, at which springs hold the body without constraint.

    Chosen by pivoted QR, so that no combination of the fields is small at all of them.

    Args:
        fields: (k, n, 3) independent; k may be 0.
        free: (n, 3) components that may be chosen.

    Returns:
        (n, 3) with k true entries.
    """
    chosen = np.zeros(free.size, bool)
    if not len(fields):
        return chosen.reshape(free.shape)
    candidates = np.flatnonzero(free)
    pivots = linalg.qr(fields.reshape(len(fields), -1)[:, candidates], mode="r", pivoting=True)[1]
    chosen[candidates[pivots[: len(fields)]]] = True
    return chosen.reshape(free.shape)
