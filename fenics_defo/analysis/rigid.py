"""Rigid motions of a body: as fields, and how many of them its constraints leave free."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

Array = NDArray[np.float64]


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


def pieces(cells: NDArray[np.int64], count: int) -> tuple[int, NDArray[np.int32]]:
    """Parts of a mesh that share no node.

    Args:
        cells: (m, c) node rows.
        count: number of nodes n.

    Returns:
        number of parts, and the part of each node (n,).
    """
    rows = np.repeat(np.arange(len(cells)), cells.shape[1])
    shape = (len(cells), count)
    incidence = sparse.csr_array((np.ones(cells.size, np.int8), (rows, cells.ravel())), shape=shape)
    links = sparse.block_array([[None, incidence], [incidence.T, None]])
    number, labels = csgraph.connected_components(links, directed=False)
    return int(number), labels[len(cells) :]


def free_motions(points: Array, cells: NDArray[np.int64], held: NDArray[np.bool_]) -> int:
    """Number of independent rigid motions that the held components leave to the parts of a body.

    Args:
        points: (n, 3) [m].
        cells: (m, c) node rows.
        held: (n, 3) true where a displacement component is zero.

    Returns:
        6 for each part, less the rank of its rigid motions at held components.
    """
    number, part_of = pieces(cells, len(points))
    total = 0
    for part in range(number):
        here = part_of == part
        own = points[here]
        centre = own.mean(axis=0)
        size = max(float(np.abs(own - centre).max()), np.finfo(float).tiny)
        motions = rigid_motions((own - centre) / size, np.zeros(3))
        at_held = motions[:, held[here]]
        rank = int(
            np.linalg.matrix_rank(
                at_held @ at_held.T, hermitian=True, tol=1e-12 * max(1, at_held.shape[1])
            )
        )
        total += 6 - rank
    return total
