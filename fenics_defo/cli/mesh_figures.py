"""Figures that describe a mesh: its volume, its pieces, the quality of its cells."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fenics_defo.fem.sources import SourceMesh
from fenics_defo.fem.sources.cell_shapes import CellShape, jacobian_determinants

Array = NDArray[np.float64]

# Each corner with the three corners joined to it by edges, right-handed.
_TET_CORNERS = ((0, 1, 2, 3), (1, 0, 3, 2), (2, 0, 1, 3), (3, 0, 2, 1))
_HEX_CORNERS = (
    *((0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7)),
    *((4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)),
)


def volume(source: SourceMesh) -> float:
    """Return the volume of all cells, curved ones included [m^3]."""
    shape = CellShape(source.kind, source.order)
    points, weights = _quadrature(source.kind)
    determinants = jacobian_determinants(source.points, source.cells, shape=shape, at=points)
    return float((determinants @ weights).sum())


def _quadrature(kind: str) -> tuple[Array, Array]:
    """Return points (27, 3) and weights (27,) on the unit cube, or folded onto the unit simplex.

    Three Gauss points in each direction are exact to degree 5: enough for the determinant of a
    second-order mapping (degree 5 in each direction on the cube; 3 on the simplex, where folding
    (u, v, w) -> (u, (1 - u) v, (1 - u)(1 - v) w) adds 2).
    """
    x, w = np.polynomial.legendre.leggauss(3)
    u, v, t = np.stack(np.meshgrid(*[0.5 + 0.5 * x] * 3, indexing="ij")).reshape(3, -1)
    weights = np.einsum("i,j,k->ijk", w, w, w).ravel() / 8.0
    if kind == "hexahedron":
        return np.stack([u, v, t], axis=1), weights
    points = np.stack([u, (1.0 - u) * v, (1.0 - u) * (1.0 - v) * t], axis=1)
    return points, weights * (1.0 - u) ** 2 * (1.0 - v)


def count_pieces(source: SourceMesh) -> int:
    """Return the number of parts that share no node."""
    cells = source.cells
    first = np.repeat(cells[:, 0], cells.shape[1] - 1)
    others = cells[:, 1:].ravel()
    size = len(source.points)
    graph = coo_array((np.ones(len(others), np.int8), (first, others)), shape=(size, size))
    return int(connected_components(graph.tocsr(), directed=False)[0])


def scaled_jacobians(source: SourceMesh) -> Array:
    """Return the scaled Jacobian of each cell (m,) [-], measured at its corners.

    The smallest determinant, over the corners, of the unit vectors along the three edges there;
    for tetrahedra the determinant of the edges by the largest product of their lengths, times
    sqrt(2). 1 for a regular cell, 0 for a flat one (Stimpson et al., The Verdict Geometric Quality
    Library, Sandia report SAND2007-1751).
    """
    is_tetrahedron = source.kind == "tetrahedron"
    corners = np.array(_TET_CORNERS if is_tetrahedron else _HEX_CORNERS)
    x = source.points[source.cells[:, : len(corners)]]
    determinants = np.empty((len(corners), len(x)))
    products = np.empty_like(determinants)
    for i, (corner, *neighbours) in enumerate(corners):
        edges = x[:, neighbours] - x[:, [corner]]
        determinants[i] = np.linalg.det(edges)
        products[i] = np.linalg.norm(edges, axis=2).prod(axis=1)
    if is_tetrahedron:
        return np.sqrt(2.0) * determinants[0] / products.max(axis=0)
    return (determinants / products).min(axis=0)
