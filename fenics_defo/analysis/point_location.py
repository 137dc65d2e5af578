"""Where a point of the body at rest lies: in which cell, and with what weights of its nodes."""

from dataclasses import dataclass

import basix
import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import LoadError
from fenics_defo.fem import Solid
from fenics_defo.fem.nodes import vtk_order

Array = NDArray[np.float64]

# How far outside a cell a point may lie, as a part of the cell: points of a round surface lie a
# little outside of its flat facets.
_OUTSIDE = 0.1
_ITERATIONS = 20
_ORDERS = {"tetra": 1, "hexahedron": 1, "tetra10": 2, "hexahedron27": 2}


@dataclass(frozen=True, slots=True)
class Place:
    """A point as a weighted mean of nodes.

    Args:
        rows: (c,) rows of ``solid.points``.
        weights: (c,) their weights, of sum 1.
    """

    rows: NDArray[np.int64]
    weights: Array


def locate_node(solid: Solid, node: int, *, what: str) -> Place:
    """A node, or, where the displacements' space has none there, its neighbours.

    Args:
        solid: body.
        node: row of ``solid.points``.
        what: what the user calls it, for the error.

    Raises:
        LoadError: there is no such node.
    """
    if isinstance(node, bool) or not isinstance(node, int | np.integer):
        raise LoadError(f"the node of {what} must be a whole number, got {node!r}")
    if not 0 <= node < solid.nodes.size:
        raise LoadError(
            f"the node of {what} must be from 0 to {solid.nodes.size - 1}, the rows of "
            f"solid.points, got {node}"
        )
    if solid.nodes.carried[node]:
        return Place(np.array([node], np.int64), np.ones(1))
    row = solid.nodes.corner_weights[[int(node)]].tocoo()
    return Place(row.coords[1].astype(np.int64), row.data)


def locate_point(solid: Solid, point: NDArray[np.float64], *, what: str) -> Place:
    """The nodes of the cell that holds a point, weighted by their shape functions there.

    Args:
        solid: body.
        point: (3,) [m] at rest.
        what: what the user calls it, for the error.

    Raises:
        LoadError: the point lies outside of the body.
    """
    nodes, order = solid.cells, _ORDERS[solid.nodes.cell_type]
    kind = "tetrahedron" if solid.nodes.cell_type.startswith("tetra") else "hexahedron"
    corners = nodes[:, : 4 if kind == "tetrahedron" else 8]
    # Straight cells are mapped by their corners, whatever the order of the displacements.
    geometry = solid.mesh_data.mesh.geometry.cmaps[0].degree
    mapped = nodes if geometry == order else corners
    x = solid.points[mapped]
    low, high = x.min(axis=1), x.max(axis=1)
    margin = _OUTSIDE * (high - low).max(axis=1)[:, None]
    near = np.flatnonzero(((low - margin <= point) & (point <= high + margin)).all(axis=1))
    if near.size:
        reference = _pull_back(kind, geometry, x[near], point)
        outside = _violation(kind, reference)
        best = int(np.argmin(outside))
        if outside[best] <= _OUTSIDE:
            values = _functions(kind, solid.order, reference[best : best + 1])[0][0]
            cell = nodes[near[best]] if solid.order == order else corners[near[best]]
            return Place(cell.astype(np.int64), values)
    distance = np.linalg.norm(solid.points - point, axis=1)
    nearest = int(np.argmin(distance))
    where = ", ".join(f"{c:.6g}" for c in solid.points[nearest])
    raise LoadError(
        f"the point {tuple(map(float, point))} of {what} lies outside of the body; the nearest "
        f"node is at ({where}) m, {distance[nearest]:.3g} m away"
    )


def _functions(kind: str, order: int, reference: Array) -> tuple[Array, Array]:
    """Lagrange functions (k, c) in VTK's order at points (k, 3), and slopes (3, k, c)."""
    element = basix.create_element(
        basix.ElementFamily.P, basix.CellType[kind], order, basix.LagrangeVariant.equispaced
    )
    table = element.tabulate(1, reference)[:, :, :, 0]
    table = table[:, :, vtk_order(kind, element.dim)]
    return table[0], table[1:]


def _pull_back(kind: str, order: int, x: Array, point: Array) -> Array:
    """Reference coordinates (k, 3) of a point in each of k cells (k, c, 3), by Newton's method."""
    reference = np.full((len(x), 3), 0.25 if kind == "tetrahedron" else 0.5)
    for _ in range(1 if kind == "tetrahedron" and order == 1 else _ITERATIONS):
        values, slopes = _functions(kind, order, reference)
        misfit = point - np.einsum("kc,kci->ki", values, x)
        jacobian = np.einsum("jkc,kci->kij", slopes, x)
        change = np.linalg.solve(jacobian, misfit[:, :, None])[:, :, 0]
        # Cells that the point is not in may lead astray: they only must not disturb.
        reference = np.clip(reference + change, -2.0, 3.0)
        if not np.abs(change).max() > 1e-13:
            break
    return reference


def _violation(kind: str, reference: Array) -> Array:
    """How far (k,) outside of the reference cell points (k, 3) lie."""
    outside = np.maximum(-reference, 0.0).max(axis=1)
    beyond = reference.sum(axis=1) if kind == "tetrahedron" else reference.max(axis=1)
    return np.asarray(np.maximum(outside, beyond - 1.0))
