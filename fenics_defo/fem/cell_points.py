"""Quadrature points in cells."""

from dataclasses import dataclass

import basix
import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.cell_kernels import PointLoops
from fenics_defo.fem.compat import dolfinx

Array = NDArray[np.float64]

#: Points evaluated at once: their tangents, 648 bytes each, then stay in the processor's cache.
BATCH = 2048


@dataclass(frozen=True, slots=True)
class CellPoints:
    """The quadrature points of some cells.

    Args:
        points: (q, 3) on the reference cell.
        weights: (c, q) of the quadrature, the Jacobian's determinant included [m³].
        loops: over them.
    """

    points: Array
    weights: Array
    loops: PointLoops


def cell_points(
    space: "dolfinx.fem.FunctionSpace", cells: NDArray[np.int32], degree: int
) -> CellPoints:
    """The quadrature points that FFCx takes for forms of that degree, in some cells."""
    mesh = space.mesh
    kind = basix.CellType[mesh.topology.cell_name()]
    points, weights = basix.make_quadrature(kind, degree)
    inverse, scaled = mapped_points(mesh, cells, points, weights)
    reference = reference_gradients(kind, space.element.basix_element.degree, points)
    nodes = np.ascontiguousarray(space.dofmap.list[cells])
    loops = PointLoops(reference, np.ascontiguousarray(inverse), scaled, nodes)
    return CellPoints(points, scaled, loops)


def mapped_points(
    mesh: "dolfinx.mesh.Mesh", cells: NDArray[np.int32], points: Array, weights: Array
) -> tuple[Array, Array]:
    """What a quadrature rule of the reference cell becomes in some cells.

    Args:
        mesh: the cells'.
        cells: (c,) this rank's.
        points: (q, 3) on the reference cell.
        weights: (q,) there.

    Returns:
        J⁻¹ (c, q, 3, 3) of the cells' maps, [k, x] = ∂ξ_k/∂X_x, and the weights times |det J|
        (c, q) [m³].
    """
    kind = basix.CellType[mesh.topology.cell_name()]
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][cells]]
    map_gradients = reference_gradients(kind, mesh.geometry.cmaps[0].degree, points)
    jacobian = np.einsum("cnk,qnl->cqkl", corners, map_gradients, optimize=True)
    scaled = np.ascontiguousarray(np.abs(np.linalg.det(jacobian)) * weights)
    return np.linalg.inv(jacobian), scaled


def reference_gradients(kind: basix.CellType, order: int, points: Array) -> Array:
    """Gradients (q, n, 3) of Lagrange's functions at points (q, 3) of the reference cell."""
    element = basix.create_element(
        basix.ElementFamily.P, kind, order, basix.LagrangeVariant.gll_warped
    )
    return np.moveaxis(element.tabulate(1, points)[1:, :, :, 0], 0, 2)
