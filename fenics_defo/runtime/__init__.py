"""What runs after FEniCSx has been forgotten: records of results and their files. NumPy only."""

from fenics_defo.runtime.archive import ArraySpec, read_archive, write_archive
from fenics_defo.runtime.atomic import atomic_path, check_writable
from fenics_defo.runtime.comparison import mac
from fenics_defo.runtime.modes import DIRECTIONS, NODES_PER_CELL, Modes, load_modes

__all__ = [
    "DIRECTIONS",
    "NODES_PER_CELL",
    "ArraySpec",
    "Modes",
    "atomic_path",
    "check_writable",
    "load_modes",
    "mac",
    "read_archive",
    "write_archive",
]
