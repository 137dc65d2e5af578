"""Ball: the body of Lamb's closed-form vibrations of a free elastic sphere."""

import math
from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]


def sphere(
    *,
    size: modelling.Size = 0.2,
    order: modelling.Order = 1,
    radius: Annotated[float, "of the ball [m]"] = 1.0,
) -> None:
    """Ball about the origin.

    At order 2 the middle nodes of the surface lie on the sphere: the error of the enclosed volume
    then shrinks with the fourth power of the size, at order 1 with the second.
    Groups: volume "body"; faces "surface".

    Args:
        size: target edge length [m]; a great circle has at least eight edges whatever it says.
        order: 1 or 2.
        radius: radius of the ball [m].

    Raises:
        MeshScriptError: a length is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size, radius=radius)
    ball = gmsh.model.occ.addSphere(0.0, 0.0, 0.0, radius)
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "body", [ball])
    modelling.name_group(2, "surface", modelling.boundary_faces())
    modelling.generate(size=min(size, 2.0 * math.pi * radius / 8), order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(sphere))
