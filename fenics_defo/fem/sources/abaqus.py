"""Abaqus and CalculiX input decks, .inp: nodes, solid elements, sets, surfaces.

Keywords are the Abaqus Keywords Reference's; case does not matter. Parts, assemblies and instances
are accepted as long as there is one part that is not moved.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.abaqus_sets import group_surfaces, read_sets
from fenics_defo.fem.sources.keyword_text import Section, read_sections
from fenics_defo.fem.sources.msh_cursor import whole
from fenics_defo.fem.sources.numbering import rows_of
from fenics_defo.fem.sources.raw_mesh import CellBlock, RawGroup, RawMesh

Integers = NDArray[np.int64]

# Beginnings of element names, longest first: C3D10M, C3D8R, S4R and the like follow the same order
# of nodes as their plain forms. Abaqus orders the mid nodes as VTK does.
ELEMENTS = (
    ("C3D20", "hexahedron20", 20),
    ("C3D15", "wedge15", 15),
    ("C3D10", "tetra10", 10),
    ("C3D8", "hexahedron", 8),
    ("C3D6", "wedge", 6),
    ("C3D5", "pyramid", 5),
    ("C3D4", "tetra", 4),
    *((f"{family}8", "quad8", 8) for family in ("S", "CPS", "CPE", "CAX", "M3D")),
    *((f"{family}6", "triangle6", 6) for family in ("S", "CPS", "CPE", "CAX", "M3D", "STRI")),
    ("STRI3", "triangle", 3),
    *((f"{family}4", "quad", 4) for family in ("S", "CPS", "CPE", "CAX", "M3D")),
    *((f"{family}3", "triangle", 3) for family in ("S", "CPS", "CPE", "CAX", "M3D", "SFM3D")),
    ("SFM3D4", "quad", 4),
    ("B32", "line3", 3),
    ("B31", "line", 2),
    ("T3D3", "line3", 3),
    ("T3D2", "line", 2),
)


@dataclass(slots=True)
class Deck:
    """Numbers of nodes and cells, and the sets that name them (keys in capitals)."""

    node_numbers: Integers
    blocks: list[CellBlock] = field(default_factory=list)
    element_sets: dict[str, list[Integers]] = field(default_factory=dict)
    node_sets: dict[str, list[Integers]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)


def read_inp(path: Path) -> RawMesh:
    """Content of an input deck.

    Raises:
        MeshError: damaged, incomplete, or with an element type that is not known.
    """
    sections = read_sections(path, comment="**", included=_included)
    _refuse_assembly(sections, path)
    numbers, points = _nodes([s for s in sections if keyword(s) == "NODE"], path)
    deck = Deck(numbers)
    for section in sections:
        if keyword(section) == "ELEMENT":
            _elements(section, deck)
    read_sets(sections, deck.element_sets, deck.node_sets, deck.names)
    raw = RawMesh(label=str(path), points=points, node_numbers=numbers, blocks=deck.blocks)
    raw.groups = _groups(deck, str(path)) + group_surfaces(
        sections, deck.blocks, deck.element_sets, label=str(path)
    )
    for number, group in enumerate(raw.groups, start=1):
        group.number = number
    return raw


def keyword(section: Section) -> str:
    """Keyword in capitals: ``Element, type=C3D4`` -> ``ELEMENT``."""
    return section.head.partition(",")[0].strip().upper()


def parameter(section: Section, name: str) -> str:
    """Value of a parameter of the keyword line; "" if it is not there."""
    for word in section.head.split(",")[1:]:
        key, _, value = word.partition("=")
        if key.strip().upper() == name:
            return value.strip().strip('"') or key.strip()
    return ""


def _included(head: str) -> str | None:
    section = Section(head=head, lines=[], where="")
    return parameter(section, "INPUT") if keyword(section) == "INCLUDE" else None


def _refuse_assembly(sections: list[Section], path: Path) -> None:
    """Instances may be moved and repeated, which a reader of one mesh would silently ignore."""
    instances = [s for s in sections if keyword(s) == "INSTANCE"]
    moved = [s for s in instances if s.lines]
    if len(instances) > 1 or moved:
        raise MeshError(
            f"{path} is an assembly of {len(instances)} instances, moved or repeated; export one "
            "part as a flat mesh (`*PREPRINT`/`model.setValues(noPartsInputFile=ON)`)"
        )


def _nodes(sections: list[Section], path: Path) -> tuple[Integers, NDArray[np.float64]]:
    if not sections:
        raise MeshError(f"{path} holds no *NODE section; it is not an Abaqus mesh or is cut off")
    tables = []
    for section in sections:
        values = section.numbers()
        if len(values) != 4 * len(section.lines):
            raise MeshError(
                f"{section.where} holds {len(section.lines)} rows and {len(values)} numbers; each "
                "row must hold a number and three coordinates"
            )
        tables.append(values.reshape(-1, 4))
    rows = np.concatenate(tables)
    return whole(rows[:, 0], str(path)), np.ascontiguousarray(rows[:, 1:])


def _elements(section: Section, deck: Deck) -> None:
    kind = parameter(section, "TYPE").upper()
    known = next(((t, c) for start, t, c in ELEMENTS if kind.startswith(start)), None)
    if known is None or kind.startswith("C3D27"):
        raise MeshError(
            f"{section.where}: element type {kind or 'none'!r} is not read; "
            "allowed are C3D4, C3D10, C3D8 and C3D20 with their variants"
        )
    cell_type, count = known
    values = section.integers()
    if len(values) % (1 + count):
        raise MeshError(
            f"{section.where} holds {len(values)} numbers, not a multiple of {1 + count} (element "
            f"and {count} nodes of {kind}); the file is incomplete"
        )
    rows = values.reshape(-1, 1 + count)
    nodes = rows_of(rows[:, 1:], deck.node_numbers, what=section.where, thing="node")
    deck.blocks.append(CellBlock(cell_type=cell_type, nodes=nodes, numbers=rows[:, 0]))
    name = parameter(section, "ELSET")
    if name:
        deck.names.setdefault("E" + name.upper(), name)
        deck.element_sets.setdefault(name.upper(), []).append(rows[:, 0])


def _groups(deck: Deck, label: str) -> list[RawGroup]:
    """Element sets by the dimension of their members, then node sets."""
    groups = []
    for key, parts in deck.element_sets.items():
        groups += _element_groups(deck, key, np.unique(np.concatenate(parts)), label)
    for key, parts in deck.node_sets.items():
        members = np.unique(np.concatenate(parts))
        what = f"{label}: node set {deck.names['N' + key]!r}"
        rows = rows_of(members, deck.node_numbers, what=what, thing="node")
        groups.append(
            RawGroup(name=deck.names["N" + key], number=0, dimension=0, parts=[rows[:, None]])
        )
    return groups


def _element_groups(deck: Deck, key: str, members: Integers, label: str) -> list[RawGroup]:
    found: dict[int, list[Integers]] = {}
    left = len(members)
    cells = 0
    for block in deck.blocks:
        rows = np.flatnonzero(np.isin(block.numbers, members))
        left -= len(rows)
        if len(rows):
            part = cells + rows if block.dimension == 3 else block.corners[rows]
            found.setdefault(block.dimension, []).append(part)
        cells += len(block.nodes) if block.dimension == 3 else 0
    name = deck.names["E" + key]
    if left > 0:
        raise MeshError(
            f"{label}: element set {name!r} names {left} elements that the file does not define; "
            "mend or save the file again"
        )
    return [RawGroup(name=name, number=0, dimension=d, parts=p) for d, p in found.items()]
