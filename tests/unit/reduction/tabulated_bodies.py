"""Bent bodies of several materials, smooth shapes on them, and coordinates of a given amplitude."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Solid
from tests.unit.fem.fem_bodies import SIDES, bent, mesh_of, source

Array = NDArray[np.float64]

SOFT = StVenantKirchhoff(young=1.0e5, poisson=0.3, density=1.0e3)
STIFF = StVenantKirchhoff(young=7.0e6, poisson=0.45, density=2.0e3)
TWO = {None: SOFT, "x>0.7": STIFF}
# Kind, order of the displacements, order of the mesh: with 2 there, curved cells.
ELEMENTS = [
    (kind, order, geometry)
    for kind in ("tetrahedron", "hexahedron")
    for order, geometry in ((1, 1), (2, 1), (2, 2))
] + [("tetrahedron", 1, 2)]


def bent_body(
    materials: Any = None, *, element: tuple[str, int, int] = ("tetrahedron", 1, 1), **options: Any
) -> Solid:
    """A sector of a ring, held at one end, of two materials if none are given."""
    kind, order, geometry = element
    options = {"fixed": ["x<1e-9"]} | options
    mesh = mesh_of(source(kind, cells=(4, 2, 1), order=geometry, mapping=bent))
    return Solid(mesh, TWO if materials is None else materials, order=order, **options)


def smooth_shapes(solid: Solid, count: int) -> Array:
    """Shapes (count, n, 3) of largest entry 1, zero at x = 0, none of them near another."""
    x, y, z = (solid.points / SIDES[0]).T
    fields = []
    for number in range(count):
        wave = np.sin((number // 3 + 1) * x) * (1.0 + y - 0.5 * z) + 0.2 * x * np.cos(number + z)
        field = np.outer(wave * x, np.eye(3)[number % 3])
        fields.append(field + 0.3 * np.outer(x * wave, np.roll([0.5, -0.2, 0.1], number)))
    shapes = np.array(fields)
    return shapes / np.abs(shapes).max(axis=(1, 2), keepdims=True)


def end_node(solid: Solid) -> int:
    """A corner of the end that is not held."""
    return int(np.argmax(solid.points @ (1.0, 1e-3, 1e-4)))


def coordinates(shapes: Array, amplitude: float, count: int = 2) -> Array:
    """Random q (count, r) whose largest displacement is a part of the body's size."""
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (count, len(shapes)))
    largest = np.abs(np.tensordot(q, shapes, 1)).max(axis=(1, 2))
    return q * (amplitude * SIDES[0] / largest)[:, None]


def relative(found: Array, wanted: Array) -> float:
    """Largest relative difference of the bodies of a batch, by the norm of each."""
    axes = tuple(range(1, np.ndim(wanted)))
    apart = np.sqrt(np.sum((np.asarray(found) - wanted) ** 2, axis=axes))
    return float(np.max(apart / np.sqrt(np.sum(np.square(wanted), axis=axes))))
