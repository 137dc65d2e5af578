"""What a mesh file holds once it has been read and checked: plain NumPy records."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """A named set of a mesh file: physical group, element set, node set or reference.

    Args:
        name: as the file writes it; ``str(number)`` where the file gives a number only.
        number: as the file writes it; where the file gives a name only, a count from 1.
        dimension: 3 cells, 2 facets, 1 edges, 0 points.
        entities: int64. Dimension 3: (k,) rows of `SourceMesh.cells`. Otherwise (k, v) rows of
            `SourceMesh.points`: the corner vertices of each facet (v = 3 or 4) or edge (v = 2), or
            the node itself (v = 1; this may be a mid node of a second-order cell).
    """

    name: str
    number: int
    dimension: int
    entities: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RegionMaterial:
    """A material that the mesh file itself gives.

    Where the regions of several records overlap, the later one holds (Vega's rule).

    Args:
        region: name of a `Group` of dimension 3; None for the whole body.
        law: "st-venant-kirchhoff" or "mooney-rivlin".
        constants: SI values, by name: young [Pa], poisson [-], density [kg/m³]; or c10, c01,
            bulk [Pa], density of c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + bulk/2 (J - 1)².
    """

    region: str | None
    law: str
    constants: dict[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceMesh:
    """A checked mesh of one kind of volume cell, in the order of its file.

    Every cell has positive Jacobian determinants, every node belongs to a cell.

    Args:
        points: (n, 3) node coordinates [m].
        cells: (m, c) int64 rows of `points`, nodes in VTK's order; c = 4, 10, 8 or 27.
        kind: "tetrahedron" or "hexahedron".
        order: polynomial degree of the cells' geometry, 1 or 2.
        node_numbers: (n,) int64, the number by which the file calls each node, from 1 on; formats
            that do not number their nodes count them in their own order, and files that count
            from 0 are raised by 1.
        cell_numbers: (m,) int64, likewise.
        groups: the file's sets, in its order.
        materials: the file's materials, in its order.
        notes: one sentence for each thing that reading changed or noticed.
        path: the file, or None for arrays.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    kind: str
    order: int
    node_numbers: NDArray[np.int64]
    cell_numbers: NDArray[np.int64]
    groups: tuple[Group, ...] = ()
    materials: tuple[RegionMaterial, ...] = ()
    notes: tuple[str, ...] = ()
    path: Path | None = None
