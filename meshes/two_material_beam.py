"""Box beam of two materials end to end: a body with two volume groups that share nodes."""

from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]


def two_material_beam(
    *,
    size: modelling.Size = 0.05,
    order: modelling.Order = 1,
    cell: modelling.Cell = "tetrahedron",
    steel: Annotated[float, "length of the steel part, from x = 0 [m]"] = 0.5,
    aluminium: Annotated[float, "length of the aluminium part [m]"] = 0.5,
    width: Annotated[float, "along y [m]"] = 0.1,
    height: Annotated[float, "along z [m]"] = 0.1,
) -> None:
    """Box beam along x, its first part of steel and the rest of aluminium.

    The parts share the nodes of their interface, so the displacement is continuous there.
    Groups: volumes "steel" and "aluminium"; faces "clamped" (x = 0), "tip" (the far end) and
    "interface" (between the two).

    Args:
        size: longest cell edge along the axes [m]; each part is cut into equal pieces.
        order: 1 or 2.
        cell: "tetrahedron" (six to a box) or "hexahedron".
        steel: length of the part that starts at x = 0 [m].
        aluminium: length of the part that ends in the tip [m].
        width: extent along y [m], centred on the axis.
        height: extent along z [m], centred on the axis.

    Raises:
        MeshScriptError: a length is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size, steel=steel, aluminium=aluminium, width=width, height=height)
    first = (3, gmsh.model.occ.addBox(0.0, -width / 2, -height / 2, steel, width, height))
    second = (3, gmsh.model.occ.addBox(steel, -width / 2, -height / 2, aluminium, width, height))
    _, (first_parts, second_parts) = gmsh.model.occ.fragment([first], [second])
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "steel", [tag for _, tag in first_parts])
    modelling.name_group(3, "aluminium", [tag for _, tag in second_parts])
    modelling.name_group(2, "clamped", modelling.faces_in_plane("x", 0.0))
    modelling.name_group(2, "tip", modelling.faces_in_plane("x", steel + aluminium))
    outside = set(modelling.boundary_faces())
    inside = [tag for _, tag in gmsh.model.getEntities(2) if tag not in outside]
    modelling.name_group(2, "interface", inside)
    modelling.make_regular(size=size, cell=cell)
    modelling.generate(size=size, order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(two_material_beam))
