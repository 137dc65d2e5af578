"""What the readers of the formats hand to the checks: blocks of any cell type, unchecked."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.sources.source_mesh import RegionMaterial

# Cell types by the names that meshio gives them: topological dimension, number of corners.
SHAPES = {
    "vertex": (0, 1),
    "line": (1, 2),
    "triangle": (2, 3),
    "quad": (2, 4),
    "tetra": (3, 4),
    "pyramid": (3, 5),
    "wedge": (3, 6),
    "hexahedron": (3, 8),
}


def shape_of(cell_type: str) -> str | None:
    """Shape of a cell type without its number of nodes: "tetra10" -> "tetra"; None if unknown."""
    shape = cell_type.rstrip("0123456789")
    return shape if shape in SHAPES else None


@dataclass(slots=True, kw_only=True)
class CellBlock:
    """Cells of one type, of any dimension.

    Args:
        cell_type: for example "tetra10", "triangle".
        nodes: (k, c) int64 rows of the points, in VTK's order.
        numbers: (k,) int64 numbers that the file gives the cells.
    """

    cell_type: str
    nodes: NDArray[np.int64]
    numbers: NDArray[np.int64]

    @property
    def dimension(self) -> int:
        """Topological dimension; -1 for a type that this package does not know."""
        shape = shape_of(self.cell_type)
        return -1 if shape is None else SHAPES[shape][0]

    @property
    def corners(self) -> NDArray[np.int64]:
        """(k, v) corner vertices."""
        shape = shape_of(self.cell_type)
        return self.nodes[:, : SHAPES[shape][1]] if shape else self.nodes[:, :0]


@dataclass(slots=True, kw_only=True)
class RawGroup:
    """A set of the file; ``parts`` are (k,) cell rows (dimension 3) or (k, v) corner rows.

    Cell rows count the cells of the three-dimensional blocks one after another.
    """

    name: str
    number: int
    dimension: int
    parts: list[NDArray[np.int64]]


@dataclass(slots=True, kw_only=True)
class RawMesh:
    """Content of a mesh file; ``label`` begins every sentence about it."""

    label: str
    points: NDArray[np.float64]
    node_numbers: NDArray[np.int64]
    blocks: list[CellBlock]
    groups: list[RawGroup] = field(default_factory=list)
    materials: list[RegionMaterial] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
