"""Sets and surfaces of Abaqus input decks."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.keyword_text import Section
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup

Integers = NDArray[np.int64]
Sets = dict[str, list[Integers]]

# Faces S1, S2, ... of solid elements (Abaqus Analysis Guide, "Solid elements"), counted from 0.
FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1)),
        *((1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    ),
}


def read_sets(
    sections: list[Section], element_sets: Sets, node_sets: Sets, names: dict[str, str]
) -> None:
    """Add the file's *ELSET and *NSET to the sets, each under its name in capitals.

    ``names`` gets the spelling of the file, under the name in capitals with E or N before it.
    """
    for section in sections:
        word, _, rest = section.head.partition(",")
        kind = word.strip().upper()
        if kind not in ("ELSET", "NSET"):
            continue
        options = {
            key.strip().upper(): value.strip().strip('"')
            for key, _, value in (option.partition("=") for option in rest.split(","))
        }
        name = options.get(kind, "")
        if not name:
            raise MeshError(f"{section.where} has no name; write *{kind}, {kind}=NAME")
        sets = element_sets if kind == "ELSET" else node_sets
        names.setdefault(kind[0] + name.upper(), name)
        members = _members(section, sets, generate="GENERATE" in options)
        sets.setdefault(name.upper(), []).append(members)


def _members(section: Section, sets: Sets, *, generate: bool) -> Integers:
    if generate:
        rows = [section.integers([line]) for line in section.lines]
        if any(len(row) not in (2, 3) or (len(row) == 3 and row[2] < 1) for row in rows):
            raise MeshError(f"{section.where}: GENERATE needs rows of first, last, positive step")
        spans = [np.arange(row[0], row[1] + 1, row[2] if len(row) == 3 else 1) for row in rows]
        return np.concatenate([np.empty(0, dtype=np.int64), *spans])
    words = [word.strip() for line in section.lines for word in line.split(",")]
    named = [word for word in words if word and not word.lstrip("-").isdigit()]
    lines = [",".join(word for word in words if word.lstrip("-").isdigit())]
    unknown = [word for word in named if word.upper() not in sets]
    if unknown:
        raise MeshError(
            f"{section.where} holds {unknown[0]!r}, which is neither a number nor a set defined "
            "before it; define that set first"
        )
    parts = [part for word in named for part in sets[word.upper()]]
    return np.concatenate([section.integers(lines), *parts])


def group_surfaces(
    sections: list[Section], blocks: list[CellBlock], element_sets: Sets, *, label: str
) -> list[RawGroup]:
    """Facet groups of the *SURFACE, TYPE=ELEMENT sections: rows of set or element, face."""
    groups = []
    for section in sections:
        words = [word.strip() for word in section.head.split(",")]
        options = {
            key.strip().upper(): value.strip()
            for key, _, value in (word.partition("=") for word in words[1:])
        }
        if words[0].upper() != "SURFACE" or options.get("TYPE", "ELEMENT").upper() != "ELEMENT":
            continue
        parts = []
        for line in section.lines:
            who, _, face = (word.strip() for word in line.partition(","))
            parts += _faces(section, who, face.upper().strip(","), blocks, element_sets)
        name = options.get("NAME", "").strip('"')
        groups.append(RawGroup(name=name, number=0, dimension=2, parts=parts))
    return groups


def _faces(
    section: Section, who: str, face: str, blocks: list[CellBlock], element_sets: Sets
) -> list[Integers]:
    if who.upper() in element_sets:
        members = np.concatenate(element_sets[who.upper()])
    elif who.isdigit():
        members = np.array([int(who)])
    else:
        raise MeshError(f"{section.where} names the element set {who!r}, which is not defined")
    if not (face[:1] == "S" and face[1:].isdigit()):
        raise MeshError(
            f"{section.where} names the face {face!r} of {who!r}; S1 to S4 of tetrahedra and "
            "S1 to S6 of hexahedra are read"
        )
    parts = []
    for block in blocks:
        faces = FACES.get(block.cell_type.rstrip("0123456789"), ())
        rows = np.flatnonzero(np.isin(block.numbers, members))
        if len(rows) and 1 <= int(face[1:]) <= len(faces):
            parts.append(block.corners[rows][:, faces[int(face[1:]) - 1]])
    return parts
