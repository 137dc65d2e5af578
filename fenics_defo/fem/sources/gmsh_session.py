"""A Gmsh session of our own, inside the caller's if there is one, which is left as it was."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.numbering import rows_of
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawMesh

TETRAHEDRON = 4  # Gmsh's element type
MOST_CELLS = 2e7  # about 20 GB in Gmsh; a larger wish is a slip of units
MODEL = "fenics_defo filling"

# Set in every session: the caller's session may have changed them.
OPTIONS = {
    "General.Terminal": 0,
    "Geometry.Tolerance": 1e-8,
    "Geometry.OCCImportLabels": 1,
    "Geometry.OCCScaling": 1,
    "Mesh.Algorithm": 6,  # frontal Delaunay
    "Mesh.Algorithm3D": 1,  # Delaunay
    "Mesh.ElementOrder": 1,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.MeshSizeFactor": 1,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.Optimize": 1,
    "Mesh.OptimizeNetgen": 0,
    "Mesh.RecombineAll": 0,
    "Mesh.Recombine3DAll": 0,
    "Mesh.SubdivisionAlgorithm": 0,
}
SIZE_OPTIONS = ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax")


@contextmanager
def gmsh_session(label: object) -> Iterator[None]:
    """An empty current model with known options; Gmsh's failures become a `MeshError`."""
    nested = bool(gmsh.isInitialized())
    if not nested:
        gmsh.initialize([], readConfigFiles=False, run=False, interruptible=False)
    current = gmsh.model.getCurrent()
    options = {name: gmsh.option.getNumber(name) for name in (*OPTIONS, *SIZE_OPTIONS)}
    unit = gmsh.option.getString("Geometry.OCCTargetUnit")
    try:
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        gmsh.option.setString("Geometry.OCCTargetUnit", "")
        gmsh.model.add(MODEL)
        yield
    except MeshError:
        raise
    except Exception as error:  # Gmsh's Python module raises nothing more precise
        said = " ".join(str(error).split())[:200] or "no reason given"
        raise MeshError(
            f"{label} cannot be filled with tetrahedra (Gmsh: {said}); "
            "try another --size (size=), or repair the geometry"
        ) from None
    finally:
        if nested:
            if MODEL in gmsh.model.list():
                gmsh.model.setCurrent(MODEL)
                gmsh.model.remove()
            gmsh.model.setCurrent(current)
            for name, value in options.items():
                gmsh.option.setNumber(name, value)
            gmsh.option.setString("Geometry.OCCTargetUnit", unit)
        else:
            gmsh.finalize()


@contextmanager
def silent_descriptors() -> Iterator[None]:
    """Send what libraries write to the process's own output and error streams to nowhere.

    OpenCASCADE prints its remarks there, past Python and past Gmsh's options.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    kept = [os.dup(descriptor) for descriptor in (1, 2)]
    try:
        for descriptor in (1, 2):
            os.dup2(nowhere, descriptor)
        yield
    finally:
        for descriptor, saved in zip((1, 2), kept, strict=True):
            os.dup2(saved, descriptor)
            os.close(saved)
        os.close(nowhere)


def set_size(size: float) -> None:
    """One edge length everywhere [m]."""
    for name in SIZE_OPTIONS:
        gmsh.option.setNumber(name, size)


def require_size(
    label: object, size: float | None, *, diagonal: float, volume: float, area: float
) -> float:
    """The edge length, if it is given and sensible for the body.

    Args:
        label: to begin a sentence with.
        size: what the user gave [m].
        diagonal: of the bounding box [m].
        volume: of the body [m³], or an upper bound.
        area: of its surface [m²], or 0 if not known.

    Raises:
        MeshError: no size, larger than the body, or so small that the mesh would not fit a machine.
    """
    proposal = f"{diagonal / 20.0:.2g}"
    if size is None:
        raise MeshError(
            f"{label} holds a surface or solid that must be filled with tetrahedra; give their "
            f"edge length, --size (size=), for example {proposal} (a twentieth of the diagonal)"
        )
    # Regular tetrahedra have the volume h³ / (6 sqrt 2), equilateral triangles sqrt(3)/4 h².
    cells = 6.0 * np.sqrt(2.0) * volume / size**3 + 4.0 / np.sqrt(3.0) * area / size**2
    if not (size <= diagonal and cells <= MOST_CELLS):
        raise MeshError(
            f"{label}: size {size:g} is out of proportion to the body, whose diagonal is "
            f"{diagonal:.4g} (about {cells:.1g} tetrahedra); give --size (size=) near {proposal}"
        )
    return size


@dataclass(frozen=True, slots=True, kw_only=True)
class Filled:
    """Tetrahedra of the current model.

    Args:
        raw: nodes and cells, numbered from 1.
        node_tags: (n,) Gmsh's number of each node.
        cell_tags: (m,) Gmsh's number of each cell.
    """

    raw: RawMesh
    node_tags: NDArray[np.int64]
    cell_tags: NDArray[np.int64]


def tetrahedra(label: str) -> Filled:
    """Mesh of the current model as made by Gmsh, nodes by their numbers."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    cell_tags, node_tags = gmsh.model.mesh.getElementsByType(TETRAHEDRON)
    if len(cell_tags) == 0:
        raise MeshError(
            f"{label} was not filled: Gmsh made no tetrahedron; try another --size (size=)"
        )
    used = np.unique(node_tags.astype(np.int64))
    rows = np.searchsorted(used, node_tags.astype(np.int64)).reshape(-1, 4)
    where = rows_of(used, tags.astype(np.int64), what=label, thing="node")
    raw = RawMesh(
        label=label,
        points=coordinates.reshape(-1, 3)[where],
        node_numbers=1 + np.arange(len(used)),
        blocks=[CellBlock(cell_type="tetra", nodes=rows, numbers=1 + np.arange(len(rows)))],
    )
    return Filled(raw=raw, node_tags=used, cell_tags=cell_tags.astype(np.int64))


def volume_of(raw: RawMesh) -> float:
    """Sum of the cells' volumes, each counted positive [m³]."""
    x = raw.points[raw.blocks[0].nodes]
    a, b, c = (x[:, i] - x[:, 0] for i in (1, 2, 3))
    return float(np.abs(np.einsum("mi,mi->m", a, np.cross(b, c))).sum() / 6.0)


def made_note(label: Path, raw: RawMesh, size: float) -> str:
    """What was made, for the notes."""
    return (
        f"{label.name} was filled with {len(raw.blocks[0].nodes)} tetrahedra of size {size:g}; "
        "nodes and cells are numbered from 1 as made."
    )
