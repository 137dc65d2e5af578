"""What the bodies share: checks, named groups, meshing; it acts on the current gmsh model."""

import math
from collections.abc import Iterable
from typing import Annotated, Literal

import gmsh
import numpy as np

Size = Annotated[float, "target edge length of the cells [m]"]
Order = Annotated[Literal[1, 2], "1: straight cells, 2: quadratic cells with curved faces"]
Cell = Annotated[Literal["tetrahedron", "hexahedron"], "shape of the cells"]
Axis = Literal["x", "y", "z"]

MAX_CELLS = 2.0e7


class MeshScriptError(ValueError):
    """A body cannot be built as asked; the message says what is allowed."""


def check_lengths(**lengths: float) -> None:
    """Raise MeshScriptError unless each of the named lengths [m] is positive and finite."""
    for name, value in lengths.items():
        if not 0.0 < value < math.inf:  # written so that NaN fails too
            raise MeshScriptError(f"{name} is {value} m; give a positive, finite length in metres.")


def divisions(length: float, size: float) -> int:
    """Number of equal cell edges, none longer than ``size``, that fill ``length`` [m].

    Raises:
        MeshScriptError: there would be more than 100,000 of them.
    """
    # The small allowance keeps 0.3 / 0.1 from becoming four edges by round-off.
    count = length / size * (1.0 - 1.0e-9)
    if not count < 1.0e5:
        raise MeshScriptError(
            f"size {size} m cuts a length of {length} m into {count:.1e} cells; "
            "give a size of at least a 100,000th of the body."
        )
    return max(1, math.ceil(count))


def name_group(dimension: int, name: str, tags: Iterable[int]) -> None:
    """Make a physical group of the entities ``tags``; at least one is needed."""
    found = sorted(tags)
    if not found:
        raise MeshScriptError(f"no part of the geometry belongs to the group {name!r}.")
    gmsh.model.addPhysicalGroup(dimension, found, name=name)


def boundary_faces() -> list[int]:
    """Tags of the faces between the body and the outside, in ascending order."""
    faces = gmsh.model.getBoundary(gmsh.model.getEntities(3), combined=True, oriented=False)
    return sorted(tag for _, tag in faces)


def faces_in_plane(axis: Axis, value: float, *, tolerance: float = 1.0e-6) -> list[int]:
    """Tags of the boundary faces that lie in a plane such as z = ``value`` [m]."""
    column = "xyz".index(axis)
    boxes = {tag: gmsh.model.getBoundingBox(2, tag) for tag in boundary_faces()}
    return [
        tag
        for tag, box in boxes.items()
        if abs(box[column] - value) < tolerance and abs(box[column + 3] - value) < tolerance
    ]


def make_regular(*, size: float, cell: str) -> None:
    """Cut every box-like volume of the current model into a regular grid of cells.

    Straight edges are cut by their own length; bent ones, concentric here, all by the
    longest and into four at least: quadratic cells on a wide arc would turn inside out.

    Args:
        size: longest cell edge along the edges of the body [m].
        cell: "tetrahedron" or "hexahedron".
    """
    curves = [tag for _, tag in gmsh.model.getEntities(1)]
    lengths = {tag: gmsh.model.occ.getMass(1, tag) for tag in curves}
    bent = {tag for tag in curves if gmsh.model.getType(1, tag) != "Line"}
    longest = max((lengths[tag] for tag in bent), default=0.0)
    for tag in curves:
        edge = min(size, longest / 4) if tag in bent else size
        cells = divisions(longest if tag in bent else lengths[tag], edge)
        gmsh.model.mesh.setTransfiniteCurve(tag, cells + 1)
    for dimension, tag in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(tag)
        if cell == "hexahedron":
            gmsh.model.mesh.setRecombine(dimension, tag)
    for _, tag in gmsh.model.getEntities(3):
        gmsh.model.mesh.setTransfiniteVolume(tag)


def generate(*, size: float, order: int, circle_cells: int = 0) -> None:
    """Mesh the current model's volumes.

    Args:
        size: longest edge asked for [m]; transfinite parts keep their own divisions.
        order: 1, or 2 for quadratic cells whose middle nodes lie on the geometry.
        circle_cells: least number of edges around a full circle, 0 for no such limit.

    Raises:
        MeshScriptError: the size asks for more than 2e7 cells.
    """
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    cells = 8.0 * volume / size**3 if size**3 > 0.0 else math.inf
    if not cells < MAX_CELLS:
        raise MeshScriptError(
            f"size {size} m asks for about {cells:.0e} cells; at most {MAX_CELLS:.0e} are made "
            f"here: give a size of at least {(8.0 * volume / MAX_CELLS) ** (1 / 3):.2g} m."
        )
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", circle_cells)
    gmsh.model.mesh.generate(3)
    if order == 2:
        gmsh.model.mesh.setOrder(2)
        if _worst_quality() < 0.1:
            # Flat cells with two faces on a round surface fold when their faces bend: better
            # straight cells are the cure, and Netgen's smoothing is worth its time only then.
            gmsh.model.mesh.setOrder(1)
            gmsh.model.mesh.optimize("Netgen")
            gmsh.model.mesh.setOrder(2)
        if _worst_quality() < 0.1:
            gmsh.model.mesh.optimize("HighOrder")  # slides middle nodes along the geometry


def _worst_quality() -> float:
    _, tags, _ = gmsh.model.mesh.getElements(3)
    return float(gmsh.model.mesh.getElementQualities(np.concatenate(tags), "minSICN").min())


def check_cells() -> float:
    """Return the worst cell quality of the current mesh: 1 regular, 0 flat, negative inverted.

    Raises:
        MeshScriptError: a cell is flat or inverted.
    """
    worst = _worst_quality()
    if not worst > 0.0:
        raise MeshScriptError(
            f"the mesh has cells turned inside out (quality {worst:.2g}); give a smaller size."
        )
    return worst
