"""Meshes, selections and bodies on DOLFINx and PETSc."""

from fenics_defo.fem.compat import dolfinx  # noqa: F401  (must come first: MPI loads before DOLFINx)

# isort: split
from fenics_defo.fem.forms import QuadratureDegrees
from fenics_defo.fem.imported import EntityGroup, ImportedMesh, MeshRecord, mesh_record
from fenics_defo.fem.reading import build_mesh, read_mesh
from fenics_defo.fem.regions import select_entities
from fenics_defo.fem.solid import Fixed, Solid

__all__ = [
    "EntityGroup",
    "Fixed",
    "ImportedMesh",
    "MeshRecord",
    "QuadratureDegrees",
    "Solid",
    "build_mesh",
    "mesh_record",
    "read_mesh",
    "select_entities",
]
