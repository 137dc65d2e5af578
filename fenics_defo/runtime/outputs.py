"""Where a reduced model's motion can be seen: shapes at nodes and at probes."""

import operator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import LoadError
from fenics_defo.runtime.forces.coordinates import checked
from fenics_defo.runtime.frozen import frozen_array, frozen_integers
from fenics_defo.runtime.modes import NODES_PER_CELL

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outputs:
    """The shapes at p nodes, and the cells between them.

    Args:
        nodes: zero-based rows of the body's nodes in the order of its file (p,), ascending.
        points: these nodes at rest (p, 3) [m].
        shapes: their displacements by each coordinate (p, 3, r), in m per unit of q.
        cells: rows of ``points`` (m, c), in the node order of VTK; none by default.
        cell_type: a key of `NODES_PER_CELL`, or empty if there are no cells.

    Raises:
        ValueError: arrays whose shapes or values do not fit together.
    """

    nodes: IntArray
    points: Array
    shapes: Array
    cells: IntArray = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int64))
    cell_type: str = ""

    def __post_init__(self) -> None:
        p = np.shape(self.nodes)[0] if np.ndim(self.nodes) == 1 else 0
        r = np.shape(self.shapes)[-1] if np.ndim(self.shapes) == 3 else 0
        nodes = frozen_integers("nodes", self.nodes, (p,))
        if p and not (nodes[0] >= 0 and (np.diff(nodes) > 0).all()):
            raise ValueError("nodes must ascend from 0 on, each node once")
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "points", frozen_array("points", self.points, (p, 3)))
        object.__setattr__(self, "shapes", frozen_array("shapes", self.shapes, (p, 3, r)))
        self._check_cells(p)

    def _check_cells(self, p: int) -> None:
        if self.cell_type and self.cell_type not in NODES_PER_CELL:
            raise ValueError(f"cell_type {self.cell_type!r} is not one of {list(NODES_PER_CELL)}")
        width = NODES_PER_CELL.get(self.cell_type, 0)
        m = np.shape(self.cells)[0] if np.ndim(self.cells) == 2 else 0
        cells = frozen_integers("cells", self.cells, (m, width))
        if cells.size and not (cells.min() >= 0 and cells.max() < p):
            raise ValueError(f"cells name nodes outside 0 to {p - 1}")
        object.__setattr__(self, "cells", cells)

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return self.shapes.shape[2]

    def displacement(self, q: ArrayLike) -> Array:
        """Return U q (..., p, 3) [m] at ``q`` (..., r): one product with a contiguous matrix.

        Raises:
            ValueError: another number of coordinates, or values that are not finite.
        """
        q = checked(q, self.size)
        rows = self.shapes.reshape(-1, self.size)
        # A vector is faster as a vector than as a matrix of one row.
        found = np.dot(rows, q) if q.ndim == 1 else np.dot(q.reshape(-1, self.size), rows.T)
        return np.asarray(found.reshape(*q.shape[:-1], *self.points.shape))

    def row(self, node: int) -> int:
        """Return the row of a node of the body.

        Raises:
            LoadError: the node is not stored, or not an integer.
        """
        try:
            wanted = operator.index(node)
        except TypeError:
            raise LoadError(
                f"a node is an integer, counted from 0 in the mesh file's order, got {node!r}."
            ) from None
        found = int(np.searchsorted(self.nodes, wanted))
        if found == self.nodes.size or self.nodes[found] != wanted:
            raise LoadError(
                f"node {wanted} is not among the {self.nodes.size} nodes stored in this model"
                f"{_extent(self.nodes)}; name one of these, or ask for it in the outputs when the "
                "body is reduced."
            )
        return found


def _extent(nodes: IntArray) -> str:
    """Say which nodes there are, counted from 0."""
    return f", {nodes[0]} to {nodes[-1]} counted from 0" if nodes.size else ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Probe:
    """The shapes at one point of the body.

    Args:
        point: at rest (3,) [m].
        shapes: its displacements by each coordinate (3, r), in m per unit of q.

    Raises:
        ValueError: other shapes, or values that are not finite.
    """

    point: Array
    shapes: Array

    def __post_init__(self) -> None:
        r = np.shape(self.shapes)[-1] if np.ndim(self.shapes) == 2 else 0
        object.__setattr__(self, "point", frozen_array("the point of a probe", self.point, (3,)))
        shapes = frozen_array("the shapes of a probe", self.shapes, (3, r))
        object.__setattr__(self, "shapes", shapes)
