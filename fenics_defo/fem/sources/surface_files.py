"""Triangles of .stl, .obj and .ply files."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.array_files import as_points, read_meshio
from fenics_defo.fem.sources.keyword_text import read_text
from fenics_defo.fem.sources.msh_cursor import text_numbers, whole

Integers = NDArray[np.int64]


def read_triangles(path: Path) -> tuple[NDArray[np.float64], Integers]:
    """Points (n, 3) and triangles (t, 3); larger polygons are split into fans.

    Raises:
        MeshError: damaged, without a face, or with faces that refer to missing points.
    """
    if path.suffix.lower() == ".obj":
        points, polygons = _read_obj(path)
    else:
        mesh, _ = read_meshio(path)
        points = as_points(mesh.points, path)
        blocks = [np.asarray(b.data) for b in mesh.cells if b.type in ("triangle", "quad")]
        others = {b.type for b in mesh.cells} - {"triangle", "quad", "vertex", "line"}
        if others:
            raise MeshError(
                f"{path} holds {', '.join(sorted(others))} cells; a closed surface of triangles "
                "is needed"
            )
        polygons = [block.astype(np.int64) for block in blocks]
    triangles = np.concatenate([np.empty((0, 3), dtype=np.int64), *map(_fan, polygons)])
    if len(triangles) == 0:
        raise MeshError(f"{path} holds no triangle; export the closed surface again")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise MeshError(f"{path} holds a face that refers to a missing point; export it again")
    bad = ~np.isfinite(points[np.unique(triangles)]).all(axis=1)
    if np.any(bad):
        raise MeshError(
            f"{path}: {np.count_nonzero(bad)} points have coordinates that are not finite; "
            "export the surface again"
        )
    return points, triangles


def _fan(polygons: Integers) -> Integers:
    """Triangles (first corner, i, i + 1) of polygons (k, v)."""
    corners = range(1, polygons.shape[1] - 1)
    return np.concatenate([polygons[:, [0, i, i + 1]] for i in corners])


def _read_obj(path: Path) -> tuple[NDArray[np.float64], list[Integers]]:
    """Lines ``v x y z`` and ``f a/ta/na b/tb/nb ...``, counted from 1, or from the end if negative.

    Negative numbers count from the vertices read so far; as all writers put a face after its
    vertices and most put all vertices first, they are only accepted in that case.
    """
    lines = read_text(path).replace("\\\n", " ").splitlines()
    kinds = np.array([line.lstrip()[:2].rstrip() for line in lines] or [""])
    where = np.flatnonzero(kinds == "v")
    values = [lines[i].split()[1:4] for i in where]
    if not values or any(len(value) != 3 for value in values):
        raise MeshError(f"{path} holds no vertices `v x y z`, or incomplete ones; export it again")
    flat = text_numbers("\n".join(map(" ".join, values)), f"{path}: vertices")
    points = flat.reshape(-1, 3)
    faces: dict[int, list[str]] = {}
    for i in np.flatnonzero(kinds == "f"):
        words = re.sub(r"/\S*", "", lines[i]).split()[1:]
        faces.setdefault(len(words), []).append(" ".join(words))
    if min(faces, default=3) < 3:
        raise MeshError(f"{path} holds a face of fewer than 3 points; export the surface again")
    polygons = []
    for count, rows in faces.items():
        numbers = text_numbers("\n".join(rows), f"{path}: faces")
        table = whole(numbers, f"{path}: faces").reshape(-1, count)
        negative = table < 0
        if np.any(negative) and np.flatnonzero(kinds == "f")[0] < where[-1]:
            raise MeshError(
                f"{path} numbers points backwards between other points; export it with "
                "positive numbers"
            )
        polygons.append(np.where(negative, len(points) + table, table - 1))
    return points, polygons
