"""From a mesh file, or arrays, to a DOLFINx mesh on any number of ranks."""

import logging
from collections.abc import Callable
from pathlib import Path

from mpi4py import MPI

from numpy.typing import ArrayLike

from fenics_defo.fem.compat import dolfinx  # noqa: F401  (MPI and DOLFINx load in the right order)
from fenics_defo.fem.distribution import distribute, without_arrays
from fenics_defo.fem.imported import ImportedMesh
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.fem.sources import SourceMesh, read_source, source_from_arrays

_log = logging.getLogger(__name__)


def read_mesh(
    path: str | Path,
    *,
    size: float | None = None,
    merge: float | None = None,
    unit: str = "m",
    comm: MPI.Comm = MPI.COMM_WORLD,
) -> ImportedMesh:
    """Read a mesh of tetrahedra or hexahedra, order 1 or 2, or fill a surface or CAD body.

    Formats: gmsh ``.msh`` (2.2, 4.1), ``.vtu``, ``.vtk``, ``.xdmf``, Abaqus ``.inp``, TetGen
    ``.node``/``.ele``, Medit ``.mesh``, Vega ``.veg``; closed surfaces ``.stl``, ``.obj``, ``.ply``
    and CAD ``.step``, ``.brep``, ``.iges``, which gmsh fills with tetrahedra. The mesh is checked.
    Rank 0 reads. Collective on ``comm``.

    Args:
        path: mesh file.
        size: edge length [m] of the tetrahedra that fill a surface or CAD body.
        merge: merge nodes that lie closer than this [m]; a seam of duplicate nodes is only reported
            if not given.
        unit: unit of the file's coordinates: "m", "cm", "mm", "um", "in" or "ft"; the mesh is in
            metres.
        comm: communicator of the mesh.

    Returns:
        DOLFINx's ``MeshData``; its ``record`` keeps the file's numbers, groups and materials.

    Raises:
        MeshError: the file cannot be read, or cannot carry a computation; on each rank.
    """
    return _imported(comm, lambda: read_source(path, size=size, merge=merge, unit=unit))


def build_mesh(
    points: ArrayLike,
    cells: ArrayLike,
    *,
    kind: str = "tetrahedron",
    merge: float | None = None,
    comm: MPI.Comm = MPI.COMM_WORLD,
) -> ImportedMesh:
    """Make a mesh of arrays, checked as a file's is; rank 0's arrays count. Collective on ``comm``.

    Args:
        points: (n, 3) coordinates [m].
        cells: (m, c) zero-based rows of ``points`` in VTK's order; c = 4 or 10, or 8, 20 or 27.
        kind: "tetrahedron" or "hexahedron".
        merge: merge nodes that lie closer than this [m].
        comm: communicator of the mesh.

    Returns:
        DOLFINx's ``MeshData`` with its ``record``.

    Raises:
        MeshError: the arrays cannot carry a computation; on each rank.
    """
    return _imported(comm, lambda: source_from_arrays(points, cells, kind=kind, merge=merge))


def _imported(comm: MPI.Comm, read: Callable[[], SourceMesh]) -> ImportedMesh:
    source = on_first_rank(comm, read, for_others=without_arrays)
    if comm.rank == 0:
        for note in source.notes:
            _log.warning("%s", note)
    return distribute(comm, source)
