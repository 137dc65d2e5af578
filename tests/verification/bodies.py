"""Bodies for comparing with theory: boxes of regular cells, the modes a test asks for, orders."""

from itertools import pairwise, permutations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo import fem
from meshes import scripting

type Array = NDArray[np.float64]
type Rows = NDArray[np.int64]

# All nodes: the coordinates of the boxes are not negative.
EVERYWHERE = "x>=0"

# Corners of the unit cube in VTK's order of the hexahedron.
_CUBE = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
# Kuhn's six tetrahedra: the ways from (0, 0, 0) to (1, 1, 1) along the axes. Cutting every cube of
# a finer grid like this cuts every tetrahedron of a coarser one: the spaces are nested.
_WAYS = np.array(
    [
        np.vstack([np.zeros(3), np.cumsum(np.eye(3)[list(order)], axis=0)])
        for order in permutations(range(3))
    ],
    dtype=int,
)
_MIRRORED = np.linalg.det(_WAYS[:, 1:]) < 0.0
_WAYS[_MIRRORED] = _WAYS[_MIRRORED][:, [0, 2, 1, 3]]


def box_arrays(kind: str, cells: tuple[int, int, int], size: ArrayLike) -> tuple[Array, Rows]:
    """Points (n, 3) [m] and equal cells (m, 4 or 8) of a box from the origin to ``size``."""
    counts = np.array(cells)
    grid = np.stack(np.meshgrid(*(np.arange(n + 1) for n in counts), indexing="ij"), axis=-1)
    origins = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
    corners = _CUBE[None] if kind == "hexahedron" else _WAYS
    at = origins.reshape(-1, 1, 1, 3) + corners[None]
    rows = np.ravel_multi_index(tuple(np.moveaxis(at, -1, 0)), tuple(counts + 1))
    return grid.reshape(-1, 3) / counts * np.asarray(size), rows.reshape(-1, corners.shape[1])


def box(kind: str, cells: tuple[int, int, int], size: ArrayLike) -> fem.ImportedMesh:
    """A box of hexahedra, or of six tetrahedra to a cube."""
    points, rows = box_arrays(kind, cells, size)
    return fem.build_mesh(points, rows, kind=kind)


def drawn(body: Any, folder: Path, **options: Any) -> fem.ImportedMesh:
    """A body of meshes/, by way of a Gmsh file."""
    path = folder / f"{body.__name__}.msh"
    scripting.write(body, path, **options)
    return fem.read_mesh(path)


def orders(errors: ArrayLike, *, ratio: float = 2.0) -> Array:
    """Observed orders p of errors ~ h^p, a row for each step to a mesh ``ratio`` times finer."""
    steps = [np.log(np.abs(a / b)) for a, b in pairwise(np.asarray(errors))]
    return np.array(steps) / np.log(ratio)


def richardson_order(values: ArrayLike) -> Array:
    """Observed order of values on three nested meshes, each twice finer, whose limit is unknown."""
    coarse, middle, fine = np.asarray(values)
    return np.log2((coarse - middle) / (middle - fine))
