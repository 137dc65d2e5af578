"""Beam bent along a quarter circle: a body whose bending and stretching couple.

The quadratic force tensor of a straight symmetric beam vanishes; that of this one does not, so
tests of quadratic terms mean something on it.
"""

import math
from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]


def bent_beam(
    *,
    size: modelling.Size = 0.05,
    order: modelling.Order = 1,
    cell: modelling.Cell = "tetrahedron",
    radius: Annotated[float, "of the quarter circle of the axis [m]"] = 0.5,
    width: Annotated[float, "along y, across the plane of the bend [m]"] = 0.1,
    height: Annotated[float, "in the plane of the bend [m]"] = 0.1,
) -> None:
    """Beam of rectangular section along a quarter circle in the xz plane, with regular cells.

    The axis starts at the origin along x and ends at (radius, 0, radius) along z. The volume is
    (pi / 2) radius width height (Pappus). Groups: volume "body"; faces "clamped" (x = 0) and
    "tip" (the other end).

    Args:
        size: longest cell edge along the edges of the body [m].
        order: 1, or 2 for cells that follow the circle.
        cell: "tetrahedron" (six to a box) or "hexahedron".
        radius: radius of the axis [m], more than height / 2.
        width: extent along y [m], centred on the axis.
        height: extent of the section in the plane of the bend [m], centred on the axis.

    Raises:
        MeshScriptError: a length is not positive, the radius is too small, or the cells would be
            too many.
    """
    modelling.check_lengths(size=size, radius=radius, width=width, height=height)
    if not radius > height / 2:
        raise modelling.MeshScriptError(
            f"radius {radius} m leaves no inner side; give more than height / 2 = {height / 2} m."
        )
    corner = (0.0, -width / 2, -height / 2)
    across = gmsh.model.occ.addPoint(*corner)
    edge = gmsh.model.occ.extrude([(0, across)], 0.0, width, 0.0)
    section = gmsh.model.occ.extrude([edge[1]], 0.0, 0.0, height)
    centre = (0.0, 0.0, radius)
    gmsh.model.occ.revolve([section[1]], *centre, 0.0, -1.0, 0.0, math.pi / 2)
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "body", [tag for _, tag in gmsh.model.getEntities(3)])
    modelling.name_group(2, "clamped", modelling.faces_in_plane("x", 0.0))
    modelling.name_group(2, "tip", modelling.faces_in_plane("z", radius))
    modelling.make_regular(size=size, cell=cell)
    modelling.generate(size=size, order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(bent_beam))
