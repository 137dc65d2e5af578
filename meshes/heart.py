"""Both ventricles of an idealised human heart at the end of its beat, cut flat at the base.

Each ventricle is half an ellipsoid with half an ellipsoid hollowed out. The left one has a cavity
with a radius of 15.5 mm and a depth of 73.5 mm in walls of 12.7 mm, the right one a cavity that
ends 19 mm from the left one's outside and 70 mm deep in walls of 6.3 mm and 12 mm at the apex:
table 8.4 of the chapter "Towards the real-time modeling of the heart" in "Advances in
Biomechanics and Tissue Regeneration" (Academic Press, 2019). The table gives cavities of 36.98 mL
and 51.21 mL: the first is that of the half ellipsoid, and where the table is silent, in the right
ventricle's place and breadth, ours was chosen to give the second.
"""

import gmsh
import numpy as np
from numpy.typing import NDArray

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

# Half-axes along x, y and z [m].
LEFT_CAVITY = (15.5e-3, 15.5e-3, 73.5e-3)
LEFT = (28.2e-3, 28.2e-3, 86.2e-3)
RIGHT_AT = -21.0e-3  # middle of the right ventricle along x; the left one's is at 0 [m]
RIGHT_CAVITY = (26.2e-3, 27.5e-3, 70.0e-3)
RIGHT = (32.5e-3, 33.8e-3, 82.0e-3)
COARSEST = 8.0e-3  # largest cell edge that follows the tips of the cavities [m]

type Array = NDArray[np.float64]
type Entity = tuple[int, int]


def _half_ellipsoid(middle: float, half_axes: tuple[float, float, float]) -> Entity:
    """The part below z = 0 of an ellipsoid about (middle, 0, 0)."""
    occ = gmsh.model.occ
    ball = [(3, occ.addSphere(0.0, 0.0, 0.0, 1.0))]
    occ.dilate(ball, 0.0, 0.0, 0.0, *half_axes)
    occ.translate(ball, middle, 0.0, 0.0)
    below = [(3, occ.addBox(-1.0, -1.0, -1.0, 2.0, 2.0, 1.0))]
    half, _ = occ.intersect(ball, below)
    return half[0]


def heart(
    *,
    size: modelling.Size = 5.0e-3,
    order: modelling.Order = 1,
) -> None:
    """Left and right ventricle, the base at z = 0 and the apex below, the right one at negative x.

    Groups: volume "myocardium"; faces "base" (the flat cut), "endocardium" (the walls of both
    cavities, the septum's included) and "epicardium" (the outside).

    Args:
        size: target edge length [m]; never more than COARSEST.
        order: 1 or 2.

    Raises:
        MeshScriptError: the size is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size)
    occ = gmsh.model.occ
    left, right = _half_ellipsoid(0.0, LEFT), _half_ellipsoid(RIGHT_AT, RIGHT)
    right_cavity, _ = occ.cut([_half_ellipsoid(RIGHT_AT, RIGHT_CAVITY)], [left], removeTool=False)
    whole, _ = occ.fuse([left], [right])
    hollow = [_half_ellipsoid(0.0, LEFT_CAVITY), *right_cavity]
    wall, _ = occ.cut(whole, hollow)
    occ.synchronize()
    modelling.name_group(3, "myocardium", [tag for _, tag in wall])
    faces = set(modelling.boundary_faces())
    # Nothing lies above the base, so only a face within it can have its centre there.
    base = {tag for tag in faces if occ.getCenterOfMass(2, tag)[2] > -1.0e-6}
    round_faces = faces - base
    endocardium = {tag for tag in round_faces if _faces_a_cavity(tag)}
    modelling.name_group(2, "base", base)
    modelling.name_group(2, "endocardium", endocardium)
    modelling.name_group(2, "epicardium", round_faces - endocardium)
    modelling.generate(size=min(size, COARSEST), order=order)


def _faces_a_cavity(face: int) -> bool:
    """True for the faces on a cavity's ellipsoid, and for the septum, the left one's in the right.

    The left ventricle's outside is cut in two where the right one meets it: the septum is the part
    on the right one's side, at negative x.
    """
    middle = gmsh.model.occ.getCenterOfMass(2, face)
    point, _ = gmsh.model.getClosestPoint(2, face, middle)
    septum = _on_ellipsoid(point, 0.0, LEFT) and middle[0] < 0.0
    return (
        septum
        or _on_ellipsoid(point, 0.0, LEFT_CAVITY)
        or _on_ellipsoid(point, RIGHT_AT, RIGHT_CAVITY)
    )


def _on_ellipsoid(point: Array, middle: float, half_axes: tuple[float, float, float]) -> bool:
    level = np.sum(((point - [middle, 0.0, 0.0]) / half_axes) ** 2)
    return bool(abs(level - 1.0) < 1.0e-6)


if __name__ == "__main__":
    raise SystemExit(scripting.run(heart))
