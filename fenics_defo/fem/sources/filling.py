"""Closed surfaces of triangles, filled with tetrahedra by Gmsh."""

from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.draft import spot
from fenics_defo.fem.sources.gmsh_session import (
    gmsh_session,
    made_note,
    require_size,
    set_size,
    tetrahedra,
    volume_of,
)
from fenics_defo.fem.sources.raw_mesh import RawMesh
from fenics_defo.fem.sources.shells import ClosedSurface, close_surface, overlap, refine
from fenics_defo.fem.sources.surface_files import read_triangles

SHARP = np.radians(40.0)  # edges sharper than this are kept; rounder ones are smoothed over
# A remeshed surface may cut corners of a curved body, but not lose a part of it.
REMESH_LOSS = 0.1
KEPT_LOSS = 1e-6
MOST_CUTS = 6


def fill_surface(path: Path, *, size: float | None) -> RawMesh:
    """Fill the closed surface of a .stl, .obj or .ply file.

    The surface is meshed anew with triangles of ``size`` between its sharp edges. Where Gmsh
    cannot do so, the file's own triangles are kept, cut into four where they are too large.

    Raises:
        MeshError: no size, or a surface that is open, branching, or crosses itself.
    """
    surface = close_surface(*read_triangles(path), path)
    x = surface.points[surface.triangles]
    area = 0.5 * float(np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum())
    diagonal = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    size = require_size(path, size, diagonal=diagonal, volume=surface.volume, area=area)
    notes = list(surface.notes)
    raw = _attempt(surface, path, size, remesh=True, loss=REMESH_LOSS)
    if raw is None:
        notes.append(
            "the surface could not be meshed anew, so its own triangles were kept; near it the "
            "cells are as large as they are."
        )
        raw = _attempt(_refined(surface, size), path, size, remesh=False, loss=KEPT_LOSS)
    if raw is None:
        raise MeshError(
            f"{path} cannot be filled: its triangles cross or touch each other, or the size "
            f"{size:g} is too coarse for its details; repair the surface or change --size (size=)"
        )
    doubled = overlap(surface, raw.points[raw.blocks[0].nodes].mean(axis=1))
    if doubled is not None:
        raise MeshError(
            f"{path}: two closed surfaces overlap near {spot(doubled)}; unite them into one "
            "surface, or move them apart"
        )
    share = 100.0 * volume_of(raw) / surface.volume
    notes.append(f"the cells fill {share:.4g} % of the volume that the surface encloses.")
    raw.notes += [made_note(path, raw, size), *notes]
    return raw


def _refined(surface: ClosedSurface, size: float) -> ClosedSurface:
    """The surface with triangles about as small as ``size``; finer ones stay as they are."""
    points, triangles, shell = surface.points, surface.triangles, surface.shell
    for _ in range(MOST_CUTS):
        x = points[triangles]
        edges = np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2)
        if np.median(edges) <= 1.5 * size:
            break
        points, triangles = refine(points, triangles)
        shell = np.repeat(shell, 4)
    return replace(surface, points=points, triangles=triangles, shell=shell)


def _attempt(
    surface: ClosedSurface, path: Path, size: float, *, remesh: bool, loss: float
) -> RawMesh | None:
    """One way of filling; None if Gmsh fails or fills another volume than the surface encloses."""
    try:
        with gmsh_session(path):
            set_size(size)
            _add_surface(surface)
            if remesh:
                gmsh.model.mesh.classifySurfaces(SHARP, True, True, np.pi)
                gmsh.model.mesh.createGeometry()
            faces = _faces_of_shells(surface)
            loops = [gmsh.model.geo.addSurfaceLoop(tags) for tags in faces]
            for shells in surface.solids:
                gmsh.model.geo.addVolume([loops[shell] for shell in shells])
            gmsh.model.geo.synchronize()
            gmsh.model.mesh.generate(3)
            raw = tetrahedra(str(path)).raw
    except MeshError:
        return None
    return raw if abs(volume_of(raw) / surface.volume - 1.0) <= loss else None


def _add_surface(surface: ClosedSurface) -> None:
    """The triangles as one discrete surface a shell; Gmsh's node i + 1 is point i."""
    tags = [gmsh.model.addDiscreteEntity(2) for _ in range(1 + int(surface.shell.max()))]
    start = 1
    for shell, tag in enumerate(tags):
        triangles = surface.triangles[surface.shell == shell]
        nodes = np.unique(triangles)
        gmsh.model.mesh.addNodes(2, tag, nodes + 1, surface.points[nodes].ravel())
        numbers = np.arange(start, start + len(triangles))
        gmsh.model.mesh.addElementsByType(tag, 2, numbers, (triangles + 1).ravel())
        start += len(triangles)


def _faces_of_shells(surface: ClosedSurface) -> list[list[int]]:
    """Gmsh's surfaces that make up each shell, after classification has cut the shells up."""
    shell_of_node = np.zeros(len(surface.points) + 1, dtype=np.int64)
    shell_of_node[surface.triangles + 1] = surface.shell[:, None]
    faces: list[list[int]] = [[] for _ in range(1 + int(surface.shell.max()))]
    for _, tag in gmsh.model.getEntities(2):
        nodes = gmsh.model.mesh.getElementsByType(2, tag)[1]
        if len(nodes):
            faces[shell_of_node[int(nodes[0])]].append(tag)
    return faces
