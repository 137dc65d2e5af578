"""Cells that a displacement has turned inside out."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem import Solid

# The three neighbours of each corner of a hexahedron in VTK's order, right-handed.
_BESIDE = np.array(
    [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)]
)


def count_inverted(solid: Solid, displacement: NDArray[np.float64]) -> int:
    """Number of cells inside out, at one of their corners at least.

    By the edges at each corner; exact for tetrahedra of order 1.

    Args:
        solid: body.
        displacement: (n, 3) [m].
    """
    x = solid.points + displacement
    if solid.nodes.cell_type.startswith("tetra"):
        corners, beside = solid.cells[:, :1], solid.cells[:, None, 1:4]
    else:
        corners = solid.cells[:, :8]
        beside = corners[:, _BESIDE]
    edges = x[beside] - x[corners][:, :, None]
    # Written so that NaN counts.
    return int((~(np.linalg.det(edges) > 0.0)).any(axis=1).sum())
