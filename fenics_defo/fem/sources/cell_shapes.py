"""Nodes, edges and faces of the cells in VTK's order, and the derivatives of their mapping.

VTK's order: corners, then mid nodes of the edges, then of the faces, then the centre. Everything
else (orders of other formats, mirror images, basis functions) is derived from these tables.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

Rows = tuple[tuple[int, ...], ...]

TET_EDGES: Rows = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TET_FACES: Rows = ((0, 1, 3), (1, 2, 3), (0, 3, 2), (0, 2, 1))
HEX_EDGES: Rows = (
    *((0, 1), (1, 2), (2, 3), (3, 0)),
    *((4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
HEX_FACES: Rows = (
    *((0, 4, 7, 3), (1, 2, 6, 5)),
    *((0, 1, 5, 4), (3, 7, 6, 2)),
    *((0, 3, 2, 1), (4, 5, 6, 7)),
)
# Gmsh's orders of the mid nodes (Gmsh reference manual, "Node ordering").
GMSH_TET_EDGES: Rows = ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))
GMSH_HEX_EDGES: Rows = (
    *((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3)),
    *((2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)),
)
GMSH_HEX_FACES: Rows = (
    *((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3)),
    *((1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)),
)


def matching(wanted: Rows, given: Rows) -> list[int]:
    """Position in ``given`` of each entity of ``wanted``, compared as sets of corners."""
    where = {frozenset(entity): i for i, entity in enumerate(given)}
    return [where[frozenset(entity)] for entity in wanted]


def gmsh_to_vtk(cell_type: str) -> list[int] | None:
    """Columns that bring Gmsh's node order to VTK's; None where the two agree."""
    if cell_type == "tetra10":
        return [*range(4), *(4 + i for i in matching(TET_EDGES, GMSH_TET_EDGES))]
    if cell_type in ("hexahedron20", "hexahedron27"):
        edges = [8 + i for i in matching(HEX_EDGES, GMSH_HEX_EDGES)]
        if cell_type == "hexahedron20":
            return [*range(8), *edges]
        faces = [20 + i for i in matching(HEX_FACES, GMSH_HEX_FACES)]
        return [*range(8), *edges, *faces, 26]
    return None


@dataclass(frozen=True)
class CellShape:
    """A cell kind of one order.

    Args:
        kind: "tetrahedron" or "hexahedron".
        order: 1 or 2; the second-order hexahedron has 27 nodes.
    """

    kind: str
    order: int

    @property
    def is_tetrahedron(self) -> bool:
        """Whether the reference cell is a simplex."""
        return self.kind == "tetrahedron"

    @property
    def edges(self) -> Rows:
        """Corner pairs of the edges."""
        return TET_EDGES if self.is_tetrahedron else HEX_EDGES

    @property
    def faces(self) -> Rows:
        """Corners of the faces, anticlockwise seen from outside."""
        return TET_FACES if self.is_tetrahedron else HEX_FACES

    @cached_property
    def entities(self) -> Rows:
        """Corners of which each node is the mean, one tuple a node."""
        corners = tuple((i,) for i in range(4 if self.is_tetrahedron else 8))
        if self.order == 1:
            return corners
        if self.is_tetrahedron:
            return (*corners, *TET_EDGES)
        return (*corners, *HEX_EDGES, *HEX_FACES, tuple(range(8)))

    @cached_property
    def mirror(self) -> list[int]:
        """Columns that turn the cell into its mirror image (determinants change sign)."""
        swap = [0, 2, 1, 3] if self.is_tetrahedron else [4, 5, 6, 7, 0, 1, 2, 3]
        return matching(
            tuple(tuple(swap[i] for i in entity) for entity in self.entities), self.entities
        )

    @cached_property
    def reference_nodes(self) -> NDArray[np.float64]:
        """(c, 3) nodes of the reference cell: unit simplex or unit cube."""
        if self.is_tetrahedron:
            corners = np.vstack([np.zeros(3), np.eye(3)])
        else:
            square = ((0, 0), (1, 0), (1, 1), (0, 1))
            corners = np.array([(x, y, z) for z in (0, 1) for x, y in square], dtype=float)
        return np.array([corners[list(entity)].mean(axis=0) for entity in self.entities])

    @cached_property
    def probes(self) -> NDArray[np.float64]:
        """(q, 3) reference points where determinants are looked at.

        The nodes of the second-order cell, where folding shows first, and interior Gauss points,
        where a computation will evaluate the mapping. A straight tetrahedron needs one point.
        """
        if self.is_tetrahedron and self.order == 1:
            return np.full((1, 3), 0.25)
        nodes = CellShape(self.kind, 2).reference_nodes
        if self.is_tetrahedron:
            a, b = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
            inside = np.full((4, 3), a)
            inside[1:] += (b - a) * np.eye(3)
        else:
            x = 0.5 + 0.5 * np.polynomial.legendre.leggauss(self.order + 1)[0]
            inside = np.array(list(product(x, repeat=3)))
        return np.vstack([nodes, inside])

    def gradients(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives of the nodal basis at reference points (q, 3), shape (q, c, 3).

        The basis is the inverse of the Vandermonde matrix of monomials x^a: |a| <= order on the
        simplex, each a_i <= order on the cube.
        """
        powers = np.array(
            [
                a
                for a in product(range(self.order + 1), repeat=3)
                if not self.is_tetrahedron or sum(a) <= self.order
            ]
        )
        coefficients = np.linalg.inv(np.prod(self.reference_nodes[:, None, :] ** powers, axis=2))
        slopes = np.empty((len(points), len(powers), 3))
        for i in range(3):
            lower = powers.copy()
            lower[:, i] = np.maximum(lower[:, i] - 1, 0)
            slopes[:, :, i] = powers[:, i] * np.prod(points[:, None, :] ** lower, axis=2)
        return np.einsum("qpi,pc->qci", slopes, coefficients)


def jacobian_determinants(
    points: NDArray[np.float64],
    cells: NDArray[np.int64],
    *,
    shape: CellShape,
    at: NDArray[np.float64],
) -> NDArray[np.float64]:
    """det(dx/dX) of the cells' mapping at reference points ``at`` (q, 3), shape (m, q) [m³]."""
    gradients = shape.gradients(at)
    result = np.empty((len(cells), len(at)))
    step = max(1, 4_000_000 // (9 * len(at)))  # about 32 MB of Jacobians at a time
    for start in range(0, len(cells), step):
        x = points[cells[start : start + step]]
        # Shifted to the first node: coordinates far from the origin would cost digits.
        x = x - x[:, :1]
        a, b, c = np.moveaxis(np.einsum("mci,qcj->mqij", x, gradients), -1, 0)
        result[start : start + step] = np.einsum("mqi,mqi->mq", a, np.cross(b, c))
    return result
