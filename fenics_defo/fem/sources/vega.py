"""Meshes of the Vega FEM library, .veg as text.

Sections *VERTICES, *ELEMENTS (TET or CUBIC), *SET, *MATERIAL (ENU, MOONEYRIVLIN), *REGION and
*INCLUDE. Meaning of each as in Vega FEM 4.0's volumetricMesh: numbers count from 1 unless one is
0, a later *REGION overrides an earlier one, the set allElements always exists. CUBIC's corners are
(0,0,0) (1,0,0) (1,1,0) (0,1,0), then the same at z = 1: VTK's order.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.keyword_text import Section, read_sections
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup, RawMesh
from fenics_defo.fem.sources.vega_materials import assign_materials, keyword

Integers = NDArray[np.int64]
ELEMENTS = {"TET": ("tetra", 4), "CUBIC": ("hexahedron", 8)}
KNOWN = ("VERTICES", "ELEMENTS", "SET", "MATERIAL", "REGION")
ALL_ELEMENTS = "allElements"


def read_vega(path: Path) -> RawMesh:
    """Content of a .veg file.

    Raises:
        MeshError: damaged, incomplete, or with a section, cell or material not supported.
    """
    sections = read_sections(path, comment="#", included=_included)
    for section in sections:
        if keyword(section)[0] not in KNOWN:
            raise MeshError(
                f"{section.where} is not a section that is read; allowed are "
                f"{', '.join('*' + name for name in (*KNOWN, 'INCLUDE'))}"
            )
    vertices = _only(sections, "VERTICES", path)
    points, node_base = _vertices(vertices)
    elements = _only(sections, "ELEMENTS", path)
    cell_type, nodes, cell_base = _elements(elements, node_base)
    raw = RawMesh(
        label=str(path),
        points=points,
        node_numbers=1 + np.arange(len(points)),
        blocks=[CellBlock(cell_type=cell_type, nodes=nodes, numbers=1 + np.arange(len(nodes)))],
    )
    if node_base == 0 or cell_base == 0:
        raw.notes.append("the file counts nodes or cells from 0; here they count from 1.")
    raw.groups = [_group(ALL_ELEMENTS, 0, np.arange(len(nodes)))]
    for section in sections:
        if keyword(section)[0] == "SET":
            raw.groups.append(_set(section, len(raw.groups), len(nodes), cell_base))
    members = {group.name: group.parts[0] for group in raw.groups}
    raw.materials = assign_materials(sections, members, cells=len(nodes), label=str(path))
    return raw


def _included(head: str) -> str | None:
    return head[7:].strip() if head.upper().startswith("INCLUDE") else None


def _only(sections: list[Section], name: str, path: Path) -> Section:
    found = [section for section in sections if keyword(section)[0] == name]
    if len(found) != 1:
        raise MeshError(f"{path} holds {len(found)} sections *{name}; a Vega mesh has one of them")
    if not found[0].lines:
        raise MeshError(f"{found[0].where} is empty; the file is incomplete")
    return found[0]


def _vertices(section: Section) -> tuple[NDArray[np.float64], int]:
    """Coordinates (n, 3), and whether vertices count from 0 or 1."""
    rows = _table(section, section.lines, 4)
    return np.ascontiguousarray(rows[:, 1:]), _base(section, rows[:, 0])


def _elements(section: Section, node_base: int) -> tuple[str, Integers, int]:
    """Cell type, rows of the points (m, c), and whether elements count from 0 or 1."""
    name = section.lines[0].upper()
    if name not in ELEMENTS:
        raise MeshError(
            f"{section.where} holds elements of type {section.lines[0][:40]!r}; "
            "allowed are TET and CUBIC"
        )
    cell_type, corners = ELEMENTS[name]
    if len(section.lines) < 2:
        raise MeshError(f"{section.where} ends before its count; the file is incomplete")
    rows = _table(section, section.lines[1:], 1 + corners)
    if np.any(rows != np.trunc(rows)):
        raise MeshError(f"{section.where} holds a vertex number that is not whole; mend the file")
    return cell_type, rows[:, 1:].astype(np.int64) - node_base, _base(section, rows[:, 0])


def _table(section: Section, lines: list[str], width: int) -> NDArray[np.float64]:
    """Rows below a line that announces how many there are."""
    header = section.numbers(lines[:1])
    count = int(header[0]) if len(header) and 0 <= header[0] < 2**53 else -1
    values = section.numbers(lines[1:])
    if len(lines) - 1 != count or len(values) != count * width:
        raise MeshError(
            f"{section.where} announces {lines[0].split()[0][:20]} rows of {width} numbers and "
            f"holds {len(lines) - 1} rows with {len(values)} numbers; the file is incomplete"
        )
    if count == 0:
        raise MeshError(f"{section.where} announces no rows; write the mesh again")
    return values.reshape(count, width)


def _base(section: Section, numbers: NDArray[np.float64]) -> int:
    """0 or 1, the number of the first row; the others must follow it one by one."""
    base = int(numbers[0]) if numbers[0] in (0.0, 1.0) else 1
    wrong = np.flatnonzero(numbers != base + np.arange(len(numbers)))
    if len(wrong):
        raise MeshError(
            f"{section.where}: row {wrong[0] + 1} has number {numbers[wrong[0]]:g}; rows must be "
            "numbered one by one from 0 or 1"
        )
    return base


def _set(section: Section, number: int, cells: int, base: int) -> RawGroup:
    rows = section.integers() - base
    bad = (rows < 0) | (rows >= cells)
    name = keyword(section)[1]
    if not name:
        raise MeshError(f"{section.where} has no name; write *SET NAME")
    if np.any(bad):
        raise MeshError(
            f"{section.where}: the set holds element {rows[bad][0] + base}; "
            f"allowed are {base} to {cells - 1 + base}"
        )
    return _group(name, number, np.unique(rows))


def _group(name: str, number: int, rows: Integers) -> RawGroup:
    return RawGroup(name=name, number=number, dimension=3, parts=[rows])
