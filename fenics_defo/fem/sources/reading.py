"""The door: a path or arrays in, a checked `SourceMesh` out."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.abaqus import read_inp
from fenics_defo.fem.sources.array_files import read_array_file
from fenics_defo.fem.sources.cad import fill_cad
from fenics_defo.fem.sources.checks import checked
from fenics_defo.fem.sources.filling import fill_surface
from fenics_defo.fem.sources.msh_file import read_msh
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawMesh
from fenics_defo.fem.sources.source_mesh import SourceMesh
from fenics_defo.fem.sources.tetgen import read_tetgen
from fenics_defo.fem.sources.vega import read_vega

READERS: dict[str, Callable[[Path], RawMesh]] = {
    ".msh": read_msh,
    ".veg": read_vega,
    ".inp": read_inp,
    ".node": read_tetgen,
    ".ele": read_tetgen,
    ".mesh": read_array_file,
    ".vtk": read_array_file,
    ".vtu": read_array_file,
    ".xdmf": read_array_file,
}
FILLERS: dict[str, Callable[..., RawMesh]] = {
    ".stl": fill_surface,
    ".obj": fill_surface,
    ".ply": fill_surface,
    ".step": fill_cad,
    ".stp": fill_cad,
    ".iges": fill_cad,
    ".igs": fill_cad,
    ".brep": fill_cad,
}
CELL_TYPES = {
    ("tetrahedron", 4): "tetra",
    ("tetrahedron", 10): "tetra10",
    ("hexahedron", 8): "hexahedron",
    ("hexahedron", 20): "hexahedron20",
    ("hexahedron", 27): "hexahedron27",
}


#: Length units that a file may be written in [m].
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}


def read_source(
    path: str | Path,
    *,
    size: float | None = None,
    merge: float | None = None,
    unit: str = "m",
) -> SourceMesh:
    """Read a mesh file, or fill a closed surface or a CAD solid with tetrahedra.

    Args:
        path: volume meshes .msh .veg .inp .node .ele .mesh .vtk .vtu .xdmf; closed surfaces .stl
            .obj .ply and CAD solids .step .stp .iges .igs .brep, which need ``size``.
        size: edge length of the tetrahedra that fill a surface or solid [m].
        merge: distance [m] within which nodes are made one; None only notes coincident nodes.
        unit: unit of the file's coordinates, a key of `LENGTH_UNITS`.

    Raises:
        MeshError: the file cannot be read, or its mesh cannot carry a computation.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    _require_file(path)
    _require_positive(path, size=size, merge=merge)
    if unit not in LENGTH_UNITS:
        raise MeshError(f"{path}: unit is {unit!r}; allowed are {', '.join(LENGTH_UNITS)}")
    metres = LENGTH_UNITS[unit]
    if suffix in FILLERS:
        raw = FILLERS[suffix](path, size=None if size is None else size / metres)
    elif suffix in READERS:
        raw = READERS[suffix](path)
        if size is not None:
            raw.notes.append("size is not used: the file holds a volume mesh already.")
    else:
        raise MeshError(
            f"{path}: {suffix or 'no suffix'} is not a known kind of mesh file; allowed are "
            f"{' '.join(READERS)} and, to be filled with tetrahedra, {' '.join(FILLERS)}"
        )
    if metres != 1.0:
        raw.points = raw.points * metres
    return checked(raw, merge=merge, path=path)


def source_from_arrays(
    points: ArrayLike,
    cells: ArrayLike,
    *,
    kind: str = "tetrahedron",
    merge: float | None = None,
) -> SourceMesh:
    """Check a mesh given as arrays, with the same checks as for files.

    Args:
        points: (n, 3) node coordinates [m].
        cells: (m, c) rows of ``points``, nodes in VTK's order; c = 4 or 10 for "tetrahedron",
            8, 20 or 27 for "hexahedron".
        kind: "tetrahedron" or "hexahedron".
        merge: as for `read_source`.

    Raises:
        MeshError: shapes that do not fit, or a mesh that cannot carry a computation.
    """
    x = _array(points, "points", float)
    nodes = _array(cells, "cells", np.int64)
    if x.ndim != 2 or x.shape[1] != 3 or len(x) == 0:
        raise MeshError(f"points have shape {x.shape}; (n, 3) with n > 0 is needed")
    key = (kind, nodes.shape[1] if nodes.ndim == 2 else 0)
    if key not in CELL_TYPES or len(nodes) == 0:
        raise MeshError(
            f"cells of kind {kind!r} have shape {nodes.shape}; allowed are (m, 4) and (m, 10) for "
            "'tetrahedron', (m, 8), (m, 20) and (m, 27) for 'hexahedron', with m > 0"
        )
    block = CellBlock(cell_type=CELL_TYPES[key], nodes=nodes, numbers=1 + np.arange(len(nodes)))
    raw = RawMesh(label="the arrays", points=x, node_numbers=1 + np.arange(len(x)), blocks=[block])
    _require_positive("the arrays", merge=merge)
    return checked(raw, merge=merge)


def _array(values: ArrayLike, name: str, dtype: type) -> np.ndarray:
    """A fresh contiguous copy; whole numbers are required of indices."""
    try:
        given = np.array(values)
        if dtype is np.int64 and given.dtype.kind not in "iu":
            raise TypeError(f"{given.dtype} instead of integers")
        return np.array(given, dtype=dtype, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(
            f"{name} cannot be read as an array of {np.dtype(dtype).name} ({error}); "
            "pass a rectangular array"
        ) from None


def _require_file(path: Path) -> None:
    try:
        if path.is_dir():
            raise MeshError(f"{path} is a directory; name a mesh file in it")
        if not path.exists():
            raise MeshError(f"{path} does not exist (looked in {path.absolute().parent})")
        with path.open("rb") as file:
            if not file.read(1):
                raise MeshError(f"{path} is empty; write the mesh again")
    except (OSError, ValueError) as error:
        if isinstance(error, MeshError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise MeshError(f"{path} cannot be opened ({reason}); check its permissions") from None


def _require_positive(label: object, **values: float | None) -> None:
    for name, value in values.items():
        if value is None:
            continue
        number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
        if not number or not 0.0 < value < np.inf:
            raise MeshError(
                f"{label}: {name} is {value!r}; --{name} ({name}=) must be a positive length"
            )
