"""Box beam with regular cells, clamped at x = 0: the body of the closed-form beam references."""

from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]


def cantilever(
    *,
    size: modelling.Size = 0.05,
    order: modelling.Order = 1,
    cell: modelling.Cell = "tetrahedron",
    length: Annotated[float, "along x [m]"] = 1.0,
    width: Annotated[float, "along y [m]"] = 0.1,
    height: Annotated[float, "along z [m]"] = 0.1,
) -> None:
    """Box beam along x with regular cells, its axis on the x axis.

    Groups: volume "body"; faces "clamped" (x = 0), "tip" (x = length), "top" (z = height / 2).

    Args:
        size: longest cell edge along the axes [m]; each side is cut into equal parts.
        order: 1 or 2.
        cell: "tetrahedron" (six to a box) or "hexahedron".
        length: extent along x [m].
        width: extent along y [m], centred on the axis.
        height: extent along z [m], centred on the axis.

    Raises:
        MeshScriptError: a length is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size, length=length, width=width, height=height)
    box = gmsh.model.occ.addBox(0.0, -width / 2, -height / 2, length, width, height)
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "body", [box])
    modelling.name_group(2, "clamped", modelling.faces_in_plane("x", 0.0))
    modelling.name_group(2, "tip", modelling.faces_in_plane("x", length))
    modelling.name_group(2, "top", modelling.faces_in_plane("z", height / 2))
    modelling.make_regular(size=size, cell=cell)
    modelling.generate(size=size, order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(cantilever))
