"""What to call cells in a sentence."""

CELL_NAMES = {
    "tetra": "tetrahedra of 4 nodes",
    "tetra10": "tetrahedra of 10 nodes",
    "hexahedron": "hexahedra of 8 nodes",
    "hexahedron27": "hexahedra of 27 nodes",
}
"""By the cell types of `fenics_defo.runtime.NODES_PER_CELL`."""
