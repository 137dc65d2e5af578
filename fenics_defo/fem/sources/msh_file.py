"""Gmsh's .msh files, formats 2 and 4.1, text and binary.

Read here and not through Gmsh, because Gmsh sorts nodes and elements by its geometry (the user's
order would be lost), runs a file that is no mesh as a script, and has one session a process, which
may be the caller's. The layout follows the Gmsh reference manual, "MSH file format".
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import msh2, msh4
from fenics_defo.fem.sources.cell_shapes import gmsh_to_vtk
from fenics_defo.fem.sources.msh_cursor import MshCursor
from fenics_defo.fem.sources.msh_elements import ElementRun
from fenics_defo.fem.sources.numbering import rows_of
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup, RawMesh

Sections = dict[str, bytes]


def read_msh(path: Path) -> RawMesh:
    """Content of a .msh file, nodes and cells in the file's order.

    Raises:
        MeshError: not a .msh file, of another version, damaged or cut off.
    """
    data = path.read_bytes()
    if not data.lstrip()[:12].startswith((b"$MeshFormat", b"$Comments")):
        raise MeshError(
            f"{path} is not a Gmsh mesh: it begins with {_shown(data)}, not with $MeshFormat; "
            "write it with `gmsh FILE -3 -o MESH.msh`"
        )
    sections = _sections(data, path)
    version, binary, swap = _format(sections, path)

    def cursor(name: str) -> MshCursor:
        what = f"{path}: section ${name}"
        if name not in sections:
            raise MeshError(f"{what} is missing; the file is incomplete, save or copy it again")
        return MshCursor(sections[name], binary=binary, swap=swap, what=what)

    if version < 4.0:
        numbers, points = msh2.read_nodes(cursor("Nodes"))
        runs = msh2.read_elements(cursor("Elements"))
    else:
        entities: msh4.Entities = {}
        for name, partitioned in (("Entities", False), ("PartitionedEntities", True)):
            if name in sections:
                entities |= msh4.read_entities(cursor(name), partitioned=partitioned)
        numbers, points = msh4.read_nodes(cursor("Nodes"))
        runs = msh4.read_elements(cursor("Elements"), entities)
    names = _physical_names(sections.get("PhysicalNames", b""), path)
    return _assemble(path, numbers, points, runs, names)


def _sections(data: bytes, path: Path) -> Sections:
    """Bodies of the sections by name; the first of a name wins."""
    sections: Sections = {}
    position = 0
    while (start := data.find(b"$", position)) >= 0:
        line_end = data.find(b"\n", start)
        name = data[start + 1 : line_end if line_end >= 0 else None].strip()
        end = data.find(b"$End" + name, line_end) if name and line_end >= 0 else -1
        if end < 0:
            raise MeshError(
                f"{path}: section ${name[:30].decode('latin-1')} is not closed; "
                "the file is cut off, save or copy it again"
            )
        sections.setdefault(name.decode("latin-1"), data[line_end + 1 : end])
        position = end + len(name) + 4
    return sections


def _format(sections: Sections, path: Path) -> tuple[float, bool, bool]:
    """Version, whether binary, whether of the other byte order."""
    words = sections.get("MeshFormat", b"").split(maxsplit=3)
    try:
        version, binary, size = float(words[0]), int(words[1]) != 0, int(words[2])
    except (IndexError, ValueError):
        raise MeshError(
            f"{path}: section $MeshFormat does not hold version, file type and size; "
            "save the mesh again"
        ) from None
    if not (2.0 <= version < 3.0 or version == 4.1) or size != 8:
        raise MeshError(
            f"{path} is of .msh version {version:g} with {size}-byte numbers; versions 2.0 to 2.2 "
            "and 4.1 with 8-byte numbers are read; convert it with "
            "`gmsh FILE -save -format msh41 -o NEW.msh`"
        )
    one = sections["MeshFormat"].partition(b"\n")[2][:4]
    return version, binary, binary and one == np.int32(1).byteswap().tobytes()


def _physical_names(body: bytes, path: Path) -> dict[tuple[int, int], str]:
    """Names of physical groups by dimension and number."""
    names = {}
    for line in body.decode("utf-8", errors="replace").splitlines()[1:]:
        words = line.split(maxsplit=2)
        if not words:
            continue
        try:
            names[int(words[0]), int(words[1])] = words[2].strip().strip('"')
        except (IndexError, ValueError):
            raise MeshError(
                f"{path}: section $PhysicalNames holds {line[:60]!r} where dimension, number and "
                "name are expected; save the mesh again"
            ) from None
    return names


def _assemble(
    path: Path,
    numbers: NDArray[np.int64],
    points: NDArray[np.float64],
    runs: list[ElementRun],
    names: dict[tuple[int, int], str],
) -> RawMesh:
    raw = RawMesh(label=str(path), points=points, node_numbers=numbers, blocks=[])
    if not runs:
        return raw
    wanted = np.concatenate([run.nodes.ravel() for run in runs])
    rows = rows_of(wanted, numbers, what=f"{path}: section $Elements", thing="node")
    found: dict[tuple[int, int], list[NDArray[np.int64]]] = {}
    start = cells = 0
    for run in runs:
        nodes = rows[start : start + run.nodes.size].reshape(run.nodes.shape)
        start += run.nodes.size
        columns = gmsh_to_vtk(run.cell_type)
        nodes = nodes if columns is None else nodes[:, columns]
        block = CellBlock(cell_type=run.cell_type, nodes=nodes, numbers=run.numbers)
        for physical, members in run.physical_members():
            part = cells + members if block.dimension == 3 else block.corners[members]
            found.setdefault((block.dimension, physical), []).append(part)
        raw.blocks.append(block)
        cells += len(nodes) if block.dimension == 3 else 0
    for (dimension, number), parts in sorted(found.items(), key=lambda item: item[0]):
        name = names.get((dimension, number), "") or str(number)
        raw.groups.append(RawGroup(name=name, number=number, dimension=dimension, parts=parts))
    empty = sorted(repr(name) for key, name in names.items() if key not in found)
    if empty:
        raw.notes.append(
            f"no element of the file belongs to physical group {', '.join(empty)} (Gmsh loses the "
            "groups when it saves format 2 with Mesh.SaveAll)."
        )
    return raw


def _shown(data: bytes) -> str:
    """The beginning of a file in printable form."""
    return repr(data[:16].decode("latin-1"))
