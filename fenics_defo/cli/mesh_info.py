"""What a mesh file holds, as a record for JSON and as text."""

import textwrap
from typing import Any

from fenics_defo.cli.cell_names import CELL_NAMES
from fenics_defo.cli.mesh_figures import count_pieces, scaled_jacobians, volume
from fenics_defo.cli.number_text import constants_text
from fenics_defo.fem.sources import read_source

_CELL_TYPES = {4: "tetra", 10: "tetra10", 8: "hexahedron", 27: "hexahedron27"}
_KINDS = {0: "nodes", 1: "edges", 2: "facets", 3: "cells"}


def mesh_record(file: str, *, size: float | None = None) -> dict[str, Any]:
    """Read a mesh and return what there is to know, ready for JSON.

    Args:
        file: mesh, or a surface or solid to be filled.
        size: edge length of the tetrahedra that fill it [m].

    Raises:
        MeshError: the file cannot be read, or its mesh cannot carry a computation.
    """
    source = read_source(file, size=size)
    quality = scaled_jacobians(source)
    return {
        "kind": "mesh",
        "file": file,
        "nodes": len(source.points),
        "cells": len(source.cells),
        "cell_type": _CELL_TYPES[source.cells.shape[1]],
        "order": source.order,
        "bounding_box": [source.points.min(axis=0).tolist(), source.points.max(axis=0).tolist()],
        "volume": volume(source),
        "pieces": count_pieces(source),
        "quality": {
            "measure": "scaled Jacobian",
            "min": float(quality.min()),
            "mean": float(quality.mean()),
        },
        "groups": [
            {"name": g.name, "number": g.number, "dimension": g.dimension, "size": len(g.entities)}
            for g in source.groups
        ],
        "materials": [
            {"region": item.region, "law": item.law, **item.constants} for item in source.materials
        ],
        "notes": list(source.notes),
    }


def mesh_text(record: dict[str, Any]) -> str:
    """Write the record of `mesh_record` for people."""
    low, high = record["bounding_box"]
    box = ", ".join(f"{a:.6g} <= {c} <= {b:.6g}" for c, a, b in zip("xyz", low, high, strict=True))
    quality = record["quality"]
    lines = [
        f"file: {record['file']}, a mesh",
        f"cells: {record['cells']} {CELL_NAMES[record['cell_type']]} (order {record['order']})",
        f"nodes: {record['nodes']}",
        f"box: {box} (m)",
        f"volume: {record['volume']:.6g} m3",
        f"pieces: {record['pieces']}",
        f"quality: {quality['min']:.3g} at least, {quality['mean']:.3g} on average "
        "(scaled Jacobian, best 1)",
        *_group_lines(record["groups"]),
        *_material_lines(record["materials"]),
    ]
    for note in record["notes"]:
        lines += textwrap.wrap(f"note: {note}", width=78, subsequent_indent="  ")
    return "\n".join(lines) + "\n"


def _group_lines(groups: list[dict[str, Any]]) -> list[str]:
    if not groups:
        return ["groups: none"]
    numbers = max(len(str(group["number"])) for group in groups)
    sizes = max(len(str(group["size"])) for group in groups)
    return ["groups: number, size, name"] + [
        f"  {group['number']:>{numbers}}  {group['size']:>{sizes}} "
        f"{_KINDS[group['dimension']]:<6}  {group['name']}"
        for group in groups
    ]


def _material_lines(materials: list[dict[str, Any]]) -> list[str]:
    if not materials:
        return ["materials: none in the file"]
    lines = ["materials:"]
    for material in materials:
        constants = {n: v for n, v in material.items() if n not in ("region", "law")}
        region = "" if material["region"] is None else f"{material['region']}: "
        lines.append(f"  {region}{constants_text(constants)} ({material['law']})")
    return lines
