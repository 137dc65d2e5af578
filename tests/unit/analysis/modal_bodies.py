"""Small bodies for the tests of vibration modes, and what the tests recompute about them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from fenics_defo.energy import LinearElastic
from fenics_defo.fem import Solid, build_mesh
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STEEL = LinearElastic(young=2.0e11, poisson=0.3, density=7800.0)

_SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
_HEXAHEDRON = np.array([(x, y, z) for z in (0, 1) for x, y in _SQUARE])  # VTK's order
# Kuhn's six tetrahedra of a cube: all share the diagonal from corner 0 to corner 6.
_TETRAHEDRA = np.array(
    [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
)


def box_arrays(
    divisions: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    *,
    kind: str = "tetrahedron",
) -> tuple[Array, Ints]:
    """Points and cells of a box from the origin to ``size``."""
    counts = np.array(divisions) + 1
    ticks = [np.linspace(0.0, s, n) for s, n in zip(size, counts, strict=True)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    first = np.stack(np.meshgrid(*map(np.arange, divisions), indexing="ij"), axis=-1)
    corners = first.reshape(-1, 1, 3) + _HEXAHEDRON
    cells = np.ravel_multi_index(tuple(np.moveaxis(corners, -1, 0)), tuple(counts))
    if kind == "tetrahedron":
        cells = cells[:, _TETRAHEDRA].reshape(-1, 4)
    return points, cells


def box(
    divisions: tuple[int, int, int] = (2, 1, 1),
    size: tuple[float, float, float] = (1.0, 0.5, 0.4),
    *,
    kind: str = "tetrahedron",
    material: Any = STEEL,
    **options: Any,
) -> Solid:
    points, cells = box_arrays(divisions, size, kind=kind)
    return Solid(build_mesh(points, cells, kind=kind), material, **options)


def joined(*parts: tuple[Array, Ints]) -> tuple[Array, Ints]:
    """Several bodies as one mesh; nodes at equal places become one."""
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    points = np.vstack([points for points, _ in parts])
    cells = np.vstack([cells + start for (_, cells), start in zip(parts, starts, strict=False)])
    unique, place = np.unique(points, axis=0, return_inverse=True)
    return unique, place.reshape(-1)[cells]


def moved(part: tuple[Array, Ints], *shift: float) -> tuple[Array, Ints]:
    return part[0] + np.array(shift), part[1]


def dense_pairs(solid: Solid, displacement: Array | None = None) -> tuple[Array, Array]:
    """All λ (k,) and shapes (k, n, 3) by SciPy's dense solver on what is not held."""
    free = np.flatnonzero(~solid.held.ravel())
    stiffness = solid.tangent(displacement).toarray()[np.ix_(free, free)]
    mass = solid.mass().toarray()[np.ix_(free, free)]
    values, vectors = linalg.eigh(stiffness, mass)
    shapes = np.zeros((len(values), solid.held.size))
    shapes[:, free] = vectors.T
    return values, shapes.reshape(len(values), -1, 3)


def gram(solid: Solid, modes: Modes) -> Array:
    """φᵀ M φ (k, k) with the mass that the body gives to users."""
    flat = modes.shapes.reshape(modes.size, -1)
    return flat @ (solid.mass() @ flat.T)


def residuals(solid: Solid, modes: Modes, displacement: Array | None = None) -> Array:
    """Relative residuals (k,) with the matrices that the body gives to users."""
    flat = modes.shapes.reshape(modes.size, -1).T
    free = ~solid.held.ravel()
    inertia = solid.mass() @ flat
    values = modes.omega**2
    difference = (solid.tangent(displacement) @ flat - inertia * values)[free]
    floor = values[values > 0.0].min(initial=np.inf)
    scale = np.maximum(values, floor) * np.linalg.norm(inertia[free], axis=0)
    return np.linalg.norm(difference, axis=0) / scale
