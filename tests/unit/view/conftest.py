from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.runtime import Modes

Array = NDArray[np.float64]
Shape = Callable[[Array], Array]

# Corners of the unit cube and of the six tetrahedra around its diagonal, VTK order.
CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
TETRAHEDRA = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
TETRA_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
HEX_EDGES = [(0, 1), (1, 2), (3, 2), (0, 3), (4, 5), (5, 6), (7, 6), (4, 7)]
HEX_EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
HEX_FACES = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]


def corner_weights(cell_type: str) -> Array:
    """Rows that give the nodes of one cell from its corners."""
    corners = 4 if cell_type.startswith("tetra") else 8
    groups: list[tuple[int, ...]] = [(i,) for i in range(corners)]
    if cell_type == "tetra10":
        groups += TETRA_EDGES
    elif cell_type == "hexahedron27":
        groups += [*HEX_EDGES, *HEX_FACES, tuple(range(8))]
    weights = np.zeros((len(groups), corners))
    for row, group in enumerate(groups):
        weights[row, list(group)] = 1.0 / len(group)
    return weights


def box_mesh(cell_type: str, cells: tuple[int, int, int], size: Array) -> tuple[Array, Any]:
    """Nodes and cells of a box, merged; nodes sorted by x, y, z."""
    origins = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), -1).reshape(-1, 1, 3)
    cubes = origins + CORNERS
    parts = cubes[:, TETRAHEDRA].reshape(-1, 4, 3) if cell_type.startswith("tetra") else cubes
    nodes = corner_weights(cell_type) @ parts
    keys, inverse = np.unique(np.round(4.0 * nodes.reshape(-1, 3)), axis=0, return_inverse=True)
    return keys / 4.0 / np.array(cells) * size, inverse.reshape(nodes.shape[:2])


@pytest.fixture
def box_modes() -> Callable[..., Modes]:
    """A box of any cell type whose modes are given functions of the points."""

    def make(cell_type: str, shapes: list[Shape], **changes: Any) -> Modes:
        cells = changes.pop("grid", (6, 1, 1))
        size = np.array(changes.pop("lengths", (4.0, 1.0, 0.5)))
        points, connectivity = box_mesh(cell_type, cells, size)
        k, n = len(shapes), len(points)
        fields: dict[str, Any] = {
            "frequencies": 100.0 * np.arange(1, k + 1),
            "shapes": np.array([shape(points) for shape in shapes]),
            "points": points,
            "cells": connectivity,
            "cell_type": cell_type,
            "node_numbers": np.arange(1, n + 1),
            "node_mass": np.full(n, 1.0 / n),
            "residuals": np.zeros(k),
            "rigid_modes": 0,
            "complete": True,
            "participation": np.zeros((k, 6)),
            "total_mass": 1.0,
            "centre": points.mean(axis=0),
            "inertia": np.ones(6),
        }
        return Modes(**(fields | changes))

    return make
