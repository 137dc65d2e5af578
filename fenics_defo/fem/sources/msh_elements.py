"""Element types of .msh files, and runs of elements of one type."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError

# Gmsh reference manual, "MSH file format": element type -> (our name, nodes). Higher orders are
# listed so that they can be counted and refused by name.
ELEMENT_TYPES = {
    15: ("vertex", 1),
    1: ("line", 2),
    8: ("line3", 3),
    26: ("line4", 4),
    27: ("line5", 5),
    28: ("line6", 6),
    2: ("triangle", 3),
    9: ("triangle6", 6),
    20: ("triangle9", 9),
    21: ("triangle10", 10),
    22: ("triangle12", 12),
    23: ("triangle15", 15),
    24: ("triangle15", 15),
    25: ("triangle21", 21),
    3: ("quad", 4),
    10: ("quad9", 9),
    16: ("quad8", 8),
    36: ("quad16", 16),
    37: ("quad25", 25),
    38: ("quad36", 36),
    4: ("tetra", 4),
    11: ("tetra10", 10),
    29: ("tetra20", 20),
    30: ("tetra35", 35),
    31: ("tetra56", 56),
    5: ("hexahedron", 8),
    12: ("hexahedron27", 27),
    17: ("hexahedron20", 20),
    92: ("hexahedron64", 64),
    93: ("hexahedron125", 125),
    94: ("hexahedron216", 216),
    6: ("wedge", 6),
    13: ("wedge18", 18),
    18: ("wedge15", 15),
    90: ("wedge40", 40),
    7: ("pyramid", 5),
    14: ("pyramid14", 14),
    19: ("pyramid13", 13),
    118: ("pyramid30", 30),
}


def element_type(number: int, what: str) -> tuple[str, int]:
    """Our name and the number of nodes of Gmsh's element type."""
    if number not in ELEMENT_TYPES:
        raise MeshError(
            f"{what} holds an element of Gmsh's type {number}, which is not known here; "
            "mesh the body with tetrahedra (types 4, 11) or hexahedra (types 5, 12, 17)"
        )
    return ELEMENT_TYPES[number]


@dataclass(frozen=True, slots=True, kw_only=True)
class ElementRun:
    """Consecutive elements of one type.

    Args:
        cell_type: our name.
        numbers: (k,) element numbers.
        nodes: (k, c) node numbers in Gmsh's order.
        physicals: physical groups of all of them (format 4.1), or of each (k,) (format 2).
    """

    cell_type: str
    numbers: NDArray[np.int64]
    nodes: NDArray[np.int64]
    physicals: tuple[int, ...] | NDArray[np.int64]

    def physical_members(self) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Each physical group with the rows of this run in it; 0 means none, signs are dropped."""
        if isinstance(self.physicals, tuple):
            for number in self.physicals:
                yield abs(number), np.arange(len(self.numbers))
            return
        groups = np.abs(self.physicals)
        for number in np.unique(groups[groups != 0]):
            yield int(number), np.flatnonzero(groups == number)
