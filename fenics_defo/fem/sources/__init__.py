"""From a mesh file, a closed surface or a CAD solid to a checked mesh of NumPy arrays.

Knows the formats and nothing of DOLFINx or MPI: under MPI one rank reads, the others receive.
"""

from fenics_defo.fem.sources.reading import read_source, source_from_arrays
from fenics_defo.fem.sources.source_mesh import Group, RegionMaterial, SourceMesh

__all__ = ["Group", "RegionMaterial", "SourceMesh", "read_source", "source_from_arrays"]
