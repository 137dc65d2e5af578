"""CAD solids of .step, .iges and .brep files, filled with tetrahedra by Gmsh (OpenCASCADE)."""

from pathlib import Path

import gmsh
import numpy as np

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.gmsh_session import (
    TETRAHEDRON,
    Filled,
    gmsh_session,
    made_note,
    require_size,
    set_size,
    silent_descriptors,
    tetrahedra,
)
from fenics_defo.fem.sources.numbering import rows_of
from fenics_defo.fem.sources.raw_mesh import RawGroup, RawMesh

Entity = tuple[int, int]
Parts = dict[tuple[int, str], list[Entity]]
TRIANGLE = 2  # Gmsh's element type
SEWN = 1e-6  # of the diagonal: gaps between the faces of a solid that are closed
BEGINNINGS = {".step": b"ISO-10303-21", ".stp": b"ISO-10303-21"}


def fill_cad(path: Path, *, size: float | None) -> RawMesh:
    """Fill the solids of a CAD file; solids that touch share the nodes of their interface.

    Named solids, and named faces of a single solid, become groups; several solids without names
    are called solid-1, solid-2, ... Coordinates are the numbers that OpenCASCADE delivers: those
    of the file for .brep, millimetres for .step and .iges.

    Raises:
        MeshError: no size, no solid, or a file that OpenCASCADE cannot read.
    """
    _require_cad(path)
    with gmsh_session(path):
        notes: list[str] = []
        volumes = _import(path, notes)
        low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
        amount = sum(abs(gmsh.model.occ.getMass(3, tag)) for _, tag in volumes)
        size = require_size(
            path, size, diagonal=float(np.linalg.norm(high - low)), volume=amount, area=0.0
        )
        named = _named_parts(volumes, notes)
        set_size(size)
        gmsh.model.mesh.generate(3)
        filled = tetrahedra(str(path))
        raw = filled.raw
        raw.groups = _groups(named, filled)
    raw.notes += [made_note(path, raw, size), *notes]
    if path.suffix.lower() != ".brep":
        raw.notes.append(
            "coordinates are in the unit of OpenCASCADE, normally millimetres, and are taken as "
            "they are; for SI results the geometry must be in metres."
        )
    return raw


def _import(path: Path, notes: list[str]) -> list[Entity]:
    """The solids of the file; faces of formats that know no solids are sewn together."""
    try:
        with silent_descriptors():
            gmsh.model.occ.importShapes(str(path), highestDimOnly=False)
            gmsh.model.occ.synchronize()
            faces = gmsh.model.getEntities(2)
            if faces and not gmsh.model.getEntities(3):
                low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
                gap = SEWN * float(np.linalg.norm(high - low))
                # All shapes at once: face by face there is nothing to sew.
                gmsh.model.occ.healShapes([], gap, sewFaces=True, makeSolids=True)
                gmsh.model.occ.synchronize()
                notes.append(f"the file's {len(faces)} faces were sewn together to solids.")
    except Exception as error:  # Gmsh's Python module raises nothing more precise
        said = " ".join(str(error).split())[:200]
        raise MeshError(f"{path} cannot be read as a CAD file ({said}); export it again") from None
    volumes = gmsh.model.getEntities(3)
    if not volumes:
        raise MeshError(
            f"{path} holds {len(faces)} faces that bound no solid; export a closed solid "
            "(in most CAD programs: make a solid from the faces)"
        )
    return volumes


def _require_cad(path: Path) -> None:
    """Refuse files of other content before OpenCASCADE reads them."""
    wanted = BEGINNINGS.get(path.suffix.lower())
    with path.open("rb") as file:
        head = file.read(256).lstrip()
    if wanted is not None and not head.startswith(wanted):
        raise MeshError(
            f"{path} is not a STEP file: it begins with {head[:16].decode('latin-1')!r}, not with "
            f"{wanted.decode()}; export it again"
        )


def _named_parts(volumes: list[Entity], notes: list[str]) -> Parts:
    """Gmsh's entities of each name; several solids are made to share their interfaces."""
    parts: Parts = {}
    labels = {entity: gmsh.model.getEntityName(*entity) for entity in gmsh.model.getEntities()}
    if len(volumes) == 1:
        named = [entity for entity, label in labels.items() if label and entity[0] >= 2]
        for entity in named:
            name = _last(labels[entity], [labels[e] for e in named if e[0] == entity[0]])
            parts.setdefault((entity[0], name), []).append(entity)
        return parts
    _, pieces = gmsh.model.occ.fragment(volumes[:1], volumes[1:])
    gmsh.model.occ.synchronize()
    notes.append(
        f"the {len(volumes)} solids share the nodes of the faces where they touch or overlap: "
        "they are joined there."
    )
    given = [labels[volume] for volume in volumes]
    for number, (label, made) in enumerate(zip(given, pieces, strict=False), start=1):
        name = _last(label, given) if label else f"solid-{number}"
        parts.setdefault((3, name), []).extend(entity for entity in made if entity[0] == 3)
    return parts


def _last(label: str, labels: list[str]) -> str:
    """The last part of a label Shapes/Assembly/Part, or all of it if that is not unique."""
    ends = [other.rpartition("/")[2] for other in labels]
    end = label.rpartition("/")[2]
    return end if end and ends.count(end) == 1 else label


def _groups(parts: Parts, filled: Filled) -> list[RawGroup]:
    groups = []
    for number, ((dimension, name), entities) in enumerate(parts.items(), start=1):
        rows = []
        for _, tag in entities:
            kind = TETRAHEDRON if dimension == 3 else TRIANGLE
            cells, nodes = (
                t.astype(np.int64) for t in gmsh.model.mesh.getElementsByType(kind, tag)
            )
            if dimension == 3:
                rows.append(rows_of(cells, filled.cell_tags, what=name, thing="cell"))
            else:
                facets = rows_of(nodes, filled.node_tags, what=name, thing="node")
                rows.append(facets.reshape(-1, 3))
        groups.append(RawGroup(name=name, number=number, dimension=dimension, parts=rows))
    return groups
