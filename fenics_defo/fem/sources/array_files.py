"""Formats that meshio reads well: .vtk, .vtu, .xdmf and Medit's .mesh.

meshio's warnings become notes; its exits and stray exceptions on damaged files become one sentence.
"""

import contextlib
import io
import warnings
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup, RawMesh

Integers = NDArray[np.int64]

# Integer cell arrays whose value 0 means "no group", with the prefix their group names do without.
REFERENCES = ("medit:ref", "gmsh:physical", "tetgen:ref")
IGNORED = ("gmsh:geometrical", "vtkGhostType", "vtkOriginalCellIds", "GlobalCellIds")
MOST_VALUES = 1000  # an integer array with more values numbers the cells and does not group them
LAGRANGE = {
    ("VTK_LAGRANGE_TETRAHEDRON", 4): "tetra",
    ("VTK_LAGRANGE_TETRAHEDRON", 10): "tetra10",
    ("VTK_LAGRANGE_HEXAHEDRON", 8): "hexahedron",
    ("VTK_LAGRANGE_HEXAHEDRON", 27): "hexahedron27",
}


def read_array_file(path: Path) -> RawMesh:
    """Content of a file that meshio reads; nodes and cells count from 1 in the file's order.

    Integer cell arrays give a group for each value: named by the value for references of Medit,
    TetGen and Gmsh and for an array that stands alone, otherwise ``array-value``. Sets of cells
    and of points give groups of their names.

    Raises:
        MeshError: meshio cannot read the file.
    """
    mesh, remarks = read_meshio(path)
    points = as_points(mesh.points, path)
    blocks: list[CellBlock] = []
    for block in mesh.cells:
        cell_type, nodes = _in_vtk_order(block.type, np.asarray(block.data))
        numbers = 1 + sum(len(b.nodes) for b in blocks) + np.arange(len(nodes))
        blocks.append(CellBlock(cell_type=cell_type, nodes=nodes, numbers=numbers))
    raw = RawMesh(
        label=str(path), points=points, node_numbers=1 + np.arange(len(points)), blocks=blocks
    )
    raw.notes += remarks
    raw.groups = _value_groups(mesh, blocks) + _set_groups(mesh, blocks)
    return raw


def read_meshio(path: Path) -> tuple[Any, list[str]]:
    """Meshio's mesh, and its remarks as notes; reads nothing from elsewhere than the file."""
    said = io.StringIO()
    try:
        with (
            warnings.catch_warnings(),
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
        ):
            warnings.simplefilter("ignore")
            mesh = meshio.read(path)
    # meshio parses without checking: a damaged file raises whatever its parser ran into.
    except (Exception, SystemExit) as error:
        if path.suffix.lower() == ".mesh" and b"TetrahedraP2" in path.read_bytes():
            raise MeshError(
                f"{path} holds second-order tetrahedra, which are not read from .mesh files; "
                "save the mesh as .msh or .vtu"
            ) from None
        reason = _reason(said.getvalue(), error)
        raise MeshError(
            f"{path} cannot be read as a {path.suffix.lower()} file ({reason}); it is damaged, "
            "cut off or of another kind, so write it again"
        ) from None
    text = " ".join(said.getvalue().split())
    if "End-of-file" in text:
        raise MeshError(f"{path} ends too early ({text}); save or copy the file again")
    return mesh, [f"meshio remarks on the file: {text}"] if text else []


def as_points(values: Any, path: Path) -> NDArray[np.float64]:
    """Coordinates as (n, 3) float64; a plane mesh gets z = 0 and fails later for its cells."""
    points = np.array(values, dtype=np.float64, order="C")
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) == 0:
        raise MeshError(f"{path} holds no points in space (shape {points.shape}); write it again")
    return points if points.shape[1] == 3 else np.pad(points, ((0, 0), (0, 1)))


def _reason(said: str, error: BaseException) -> str:
    """What meshio printed and raised, in one line without its decoration."""
    text = "" if isinstance(error, SystemExit) else str(error)
    line = " ".join(f"{said} {text}".split()).replace("Error: ", "").strip()
    return line[:200] or f"its parser stops with {type(error).__name__}"


def _in_vtk_order(cell_type: str, data: NDArray[Any]) -> tuple[str, Integers]:
    if data.ndim != 2:  # polyhedra are ragged
        return cell_type, np.zeros((len(data), 0), dtype=np.int64)
    nodes = data.astype(np.int64)
    return LAGRANGE.get((cell_type, nodes.shape[1]), cell_type), nodes


def _value_groups(mesh: Any, blocks: list[CellBlock]) -> list[RawGroup]:
    arrays = {
        name: [np.asarray(part) for part in parts]
        for name, parts in mesh.cell_data.items()
        if name not in IGNORED
    }
    arrays = {name: parts for name, parts in arrays.items() if _groups_cells(parts, blocks)}
    groups: list[RawGroup] = []
    for name, parts in arrays.items():
        plain = len(arrays) == 1 or name in REFERENCES
        for value in np.unique(np.concatenate(parts)).tolist():
            if value == 0 and name in REFERENCES:
                continue
            label = str(value) if plain else f"{name}-{value}"
            masks = [part == value for part in parts]
            # A second array may not reuse the numbers of the first.
            number = value if plain else _free_number(groups)
            groups += _by_dimension(label, number, masks, blocks)
    return groups


def _groups_cells(parts: list[NDArray[Any]], blocks: list[CellBlock]) -> bool:
    if (
        not parts
        or len(parts) != len(blocks)
        or any(part.ndim != 1 or part.dtype.kind not in "iu" for part in parts)
    ):
        return False
    if any(len(part) != len(block.nodes) for part, block in zip(parts, blocks, strict=True)):
        return False
    return 0 < len(np.unique(np.concatenate(parts))) <= MOST_VALUES


def _free_number(groups: list[RawGroup]) -> int:
    return 1 + max((group.number for group in groups), default=0)


def _set_groups(mesh: Any, blocks: list[CellBlock]) -> list[RawGroup]:
    groups: list[RawGroup] = []
    for number, (name, parts) in enumerate(mesh.cell_sets.items(), start=1):
        masks = [np.zeros(len(block.nodes), dtype=bool) for block in blocks]
        for mask, part in zip(masks, parts, strict=False):
            if part is not None:
                mask[np.asarray(part, dtype=np.int64)] = True
        groups += _by_dimension(str(name), number, masks, blocks)
    for number, (name, rows) in enumerate(mesh.point_sets.items(), start=1):
        part = np.asarray(rows, dtype=np.int64)[:, None]
        groups.append(RawGroup(name=str(name), number=number, dimension=0, parts=[part]))
    return groups


def _by_dimension(
    name: str, number: int, masks: list[NDArray[np.bool_]], blocks: list[CellBlock]
) -> list[RawGroup]:
    """One group for each dimension of the marked cells."""
    found: dict[int, list[Integers]] = {}
    cells = 0
    for mask, block in zip(masks, blocks, strict=True):
        rows = np.flatnonzero(mask)
        if len(rows) and block.dimension >= 0:
            part = cells + rows if block.dimension == 3 else block.corners[rows]
            found.setdefault(block.dimension, []).append(part)
        cells += len(block.nodes) if block.dimension == 3 else 0
    return [
        RawGroup(name=name, number=number, dimension=dimension, parts=parts)
        for dimension, parts in found.items()
    ]
