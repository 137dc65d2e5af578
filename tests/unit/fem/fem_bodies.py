"""Small meshes with known geometry for the tests of ``fem``."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.energy import NeoHookean, StVenantKirchhoff
from fenics_defo.fem.compat import MPI
from fenics_defo.fem.distribution import distribute
from fenics_defo.fem.sources import Group, SourceMesh, source_from_arrays
from fenics_defo.fem.sources.cell_shapes import CellShape

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mapping = Callable[[Array], Array]

SIDES = (2.0, 0.7, 0.5)
VOLUME = float(np.prod(SIDES))
KINDS = ("tetrahedron", "hexahedron")
MODULI = {"young": 1.0e5, "poisson": 0.3, "density": 1.2e3}
SVK, NEO = StVenantKirchhoff(**MODULI), NeoHookean(**MODULI)
# kind, order of the displacements, order of the mesh
CELLS = [(kind, order, 1) for kind in KINDS for order in (1, 2)]
# The six tetrahedra of a cube that share its diagonal 0-6.
SIXTHS = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))


def straight(points: Array) -> Array:
    return points


def tapered(points: Array) -> Array:
    """Planes stay planes and edges straight, but no cell is a parallelepiped."""
    x, y, z = points.T
    return np.column_stack([x, y * (1.0 - 0.2 * x), z * (1.0 - 0.15 * x) + 0.1 * x])


def bent(points: Array) -> Array:
    """The bar of length SIDES[0] as a sector of a ring about the y axis, inner radius 1.5."""
    x, y, z = points.T
    angle, radius = x / SIDES[0], 1.5 + z
    return np.column_stack([radius * np.sin(angle), y, radius * np.cos(angle)])


BENT_VOLUME = SIDES[1] * (2.0**2 - 1.5**2) / 2.0  # one radian of the ring


def box(
    kind: str,
    *,
    cells: tuple[int, int, int] = (3, 2, 1),
    order: int = 1,
    mapping: Mapping = straight,
    seed: int | None = 0,
) -> tuple[Array, Integers]:
    """Points and cells, VTK's order, of a box of sides SIDES; shuffled unless ``seed`` is None.

    ``mapping`` moves mid nodes too, so that second-order cells are curved by it.
    """
    ticks = [np.linspace(0.0, side, n + 1) for side, n in zip(SIDES, cells, strict=True)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(points)).reshape([n + 1 for n in cells])
    corners = CellShape("hexahedron", 1).reference_nodes.astype(int)
    nodes = np.stack(
        [
            index[tuple(slice(a, n + a) for a, n in zip(corner, cells, strict=True))].ravel()
            for corner in corners
        ],
        axis=1,
    )
    if kind == "tetrahedron":
        nodes = np.concatenate([nodes[:, list(part)] for part in SIXTHS])
    if order == 2:
        points, nodes = with_mid_nodes(points, nodes, kind)
    points = mapping(points)
    if seed is None:
        return points, nodes
    rng = np.random.default_rng(seed)
    shuffle = rng.permutation(len(points))
    return points[shuffle], np.argsort(shuffle)[nodes][rng.permutation(len(nodes))]


def with_mid_nodes(points: Array, cells: Integers, kind: str) -> tuple[Array, Integers]:
    """The second-order mesh on a first-order one; each mid node the mean of its corners."""
    entities = CellShape(kind, 2).entities
    new: dict[tuple[int, ...], int] = {}
    rows = []
    for cell in cells:
        keys = [tuple(sorted(cell[list(entity)])) for entity in entities[cells.shape[1] :]]
        mids = [new.setdefault(key, len(points) + len(new)) for key in keys]
        rows.append([*cell, *mids])
    extra = np.array([points[list(key)].mean(axis=0) for key in new])
    return np.vstack([points, extra]), np.array(rows)


def source(
    kind: str, *, groups: Callable[[Array, Integers], list[Group]] | None = None, **options: object
) -> SourceMesh:
    """A checked box; ``groups`` makes its groups from its points and cells."""
    mesh = source_from_arrays(*box(kind, **options), kind=kind)  # type: ignore[arg-type]
    made = groups(mesh.points, mesh.cells) if groups else []
    return replace(mesh, groups=tuple(made))


def mesh_of(mesh: SourceMesh) -> fem.ImportedMesh:
    return distribute(MPI.COMM_WORLD, mesh)


def facets(cells: Integers, kind: str, wanted: NDArray[np.bool_]) -> Integers:
    """Corner rows of the facets all of whose corners are ``wanted`` (n,) nodes."""
    shape = CellShape(kind, 1)
    every = np.concatenate([cells[:, list(face)] for face in shape.faces])
    chosen = every[wanted[every].all(axis=1)]
    _, at = np.unique(np.sort(chosen, axis=1), axis=0, return_index=True)
    return chosen[at]


def usual_groups(kind: str) -> Callable[[Array, Integers], list[Group]]:
    """Volumes "left" (1), "right" (2), overlapping "middle" (5); facets, edges, nodes at x = 0."""

    def make(points: Array, cells: Integers) -> list[Group]:
        shape = CellShape(kind, 1)
        corners = cells[:, : len(shape.reference_nodes)]
        middle = points[corners].mean(axis=1)[:, 0]
        root = np.abs(points[:, 0]) < 1e-9
        edges = np.concatenate([corners[:, list(edge)] for edge in shape.edges])
        lower = edges[(root & (points[:, 2] < 1e-9))[edges].all(axis=1)]
        third = SIDES[0] / 3.0

        def volumes(name: str, number: int, chosen: NDArray[np.bool_]) -> Group:
            return Group(name=name, number=number, dimension=3, entities=np.flatnonzero(chosen))

        return [
            volumes("left", 1, middle < third),
            volumes("right", 2, middle >= third),
            volumes("middle", 5, (middle > third) & (middle < 2.0 * third)),
            Group(name="root", number=7, dimension=2, entities=facets(corners, kind, root)),
            Group(name="9", number=9, dimension=1, entities=np.unique(np.sort(lower), axis=0)),
            Group(name="pins", number=4, dimension=0, entities=np.flatnonzero(root)[:, None]),
        ]

    return make


@cache
def bar(
    kind: str, order: int, mesh_order: int = 1, *, law: Any = NEO, mapping: Any = tapered
) -> fem.Solid:
    mesh = source(kind, cells=(2, 2, 2), order=mesh_order, mapping=mapping)
    return fem.Solid(mesh_of(mesh), law, order=order)


def bend(solid: fem.Solid, size: float = 0.1) -> Array:
    """A smooth bending and twisting displacement."""
    x, y, z = solid.points.T
    return size * np.column_stack([-x * z + 0.3 * y * y, x * x * 0.4 + z * y, 0.5 * x * x - x * y])
