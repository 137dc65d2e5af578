"""The visible surface of a body with its modes, smooth where the body is."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime import Modes
from fenics_defo.runtime.recording import VTK_CELL_TYPES
from fenics_defo.view.offscreen import pyvista

Array = NDArray[np.float64]

_FEATURE_ANGLE = 35.0  # degrees between facets that make an edge, more than coarse round parts have
_FEW_FACES, _MANY_FACES = 1500, 20_000  # on the surface; more are smooth with less subdivision


@dataclass(frozen=True, slots=True, kw_only=True)
class Skin:
    """Surface at rest, its sharp edges, and the displacement of both in each mode.

    Args:
        surface: triangles or quadrilaterals whose vertices are double along sharp edges.
        edges: lines along sharp edges.
        surface_moves: displacements of the vertices of the surface (k, s, 3).
        edge_moves: displacements of the vertices of the edges (k, e, 3).
        sides: pairs of vertices of the surface that a side of a face joins (2, j).
        blur: rounds in which a normal takes part of its neighbours'.
    """

    surface: Any
    edges: Any
    surface_moves: Array
    edge_moves: Array
    sides: NDArray[np.int64]
    blur: int


def skin(modes: Modes) -> Skin:
    """Extract the surface; faces of second order are cut up and follow their curves."""
    grid = pyvista.UnstructuredGrid(
        {VTK_CELL_TYPES[modes.cell_type]: modes.cells}, np.array(modes.points)
    )
    for index, shape in enumerate(modes.shapes):
        grid.point_data[f"mode {index}"] = shape
    level = _subdivision(modes)
    faces = grid.extract_surface(nonlinear_subdivision=level, algorithm="dataset_surface")
    edges = faces.extract_feature_edges(
        _FEATURE_ANGLE, boundary_edges=True, manifold_edges=False, non_manifold_edges=False
    )
    surface = faces.compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=_FEATURE_ANGLE
    )
    return Skin(
        surface=surface,
        edges=edges,
        surface_moves=_take_moves(surface, modes.size),
        edge_moves=_take_moves(edges, modes.size),
        sides=_sides(surface.regular_faces),
        # Second-order cells often have straight sides at rest: facets that would stay visible.
        blur=2**level if level else 0,
    )


def _subdivision(modes: Modes) -> int:
    """Return how often to halve the sides of faces, 0 for those of first order."""
    if modes.cell_type not in ("tetra10", "hexahedron27"):
        return 0
    # A compact body of m cells has some 6 m^(2/3) faces on its surface.
    faces = 6.0 * len(modes.cells) ** (2.0 / 3.0)
    return 3 if faces < _FEW_FACES else 2 if faces < _MANY_FACES else 1


def _sides(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    ends = np.stack([faces, np.roll(faces, 1, axis=1)], axis=-1).reshape(-1, 2)
    return ends.T.astype(np.int64)


def displaced(body: Skin, index: int, factor: float) -> Any:
    """Return the surface displaced by ``factor`` times a mode, with smooth normals."""
    surface = body.surface.copy()
    surface.points = body.surface.points + factor * body.surface_moves[index]
    surface = surface.compute_normals(
        cell_normals=False, split_vertices=False, consistent_normals=False
    )
    normals = np.array(surface.point_data["Normals"], dtype=float)
    a, b = body.sides
    for _ in range(body.blur):
        for axis in range(3):
            column = normals[:, axis].copy()
            near = np.bincount(a, column[b], len(column)) + np.bincount(b, column[a], len(column))
            normals[:, axis] += near / 4.0
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    surface.point_data["Normals"] = normals.astype(np.float32)
    return surface


def _take_moves(mesh: Any, count: int) -> Array:
    """Move the displacements out of ``mesh``, which keeps nothing but its geometry."""
    moves = np.zeros((count, mesh.n_points, 3))
    for index in range(count if mesh.n_points else 0):
        moves[index] = mesh.point_data[f"mode {index}"]
    mesh.clear_data()
    return moves


def largest_scale(body: Skin, move: Array, rotation: float) -> float:
    """Return the factor on ``move`` (s, 3) at which nearly no side of a face turns further.

    Displacements are linear in the rotations of the body, and swell it where these are large.

    Args:
        body: the surface.
        move: displacements of its vertices.
        rotation: largest relative displacement of the ends of a side over its length [-].
    """
    a, b = body.sides
    points = np.asarray(body.surface.points)
    length = np.linalg.norm(points[a] - points[b], axis=1)
    change = np.linalg.norm(move[a] - move[b], axis=1)
    ratio = np.divide(change, length, out=np.zeros_like(change), where=length > 0.0)
    steepest = np.percentile(ratio, 98.0)
    return rotation / steepest if steepest > 0.0 else np.inf
