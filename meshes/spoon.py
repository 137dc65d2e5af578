"""Table spoon, 200 mm long, with a bowl of 70 mm by 43 mm and 9 mm deep, of 2 mm to 3 mm sheet.

It is cut from flat sheet and pressed, as spoons are: the flat blank is meshed, and every node is
then carried to the curved middle surface and along its normal. A size of 2.1 mm gives
10,836 degrees of freedom at order 1.
"""

import gmsh
import numpy as np
from numpy.typing import NDArray

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

type Array = NDArray[np.float64]

LENGTH = 0.200  # [m]
BOWL_CENTRE = 0.030  # deepest point, from the tip of the bowl at x = 0 [m]
BOWL = (0.030, 0.040, 0.0215)  # half-axes of the egg: to the tip, to the handle, across [m]
BOWL_DEPTH = 0.010  # of the dish whose part inside 0.8 times its radius is the bowl [m]
RIM = 0.8
NECK = 0.068  # where the bowl ends and the handle begins [m]
HELD_FROM = 0.165  # the end of the handle that the hand holds starts here [m]
RISE = 0.028  # scale of the handle's curve, which rises to 0.7 of it [m]
SHEET = 2.0e-3  # thickness of the bowl and of the handle's end [m]
NECK_SHEET = 3.0e-3  # thickness where the handle is narrowest [m]
# Half the width of the handle (second column) along the spoon [m].
HANDLE = np.array(
    [
        [0.0770, 0.0050],
        [0.0950, 0.0037],
        [0.1200, 0.0044],
        [0.1450, 0.0064],
        [0.1700, 0.0089],
        [0.1850, 0.0099],
        [0.1940, 0.0083],
        [0.1985, 0.0048],
    ]
)


def _outline() -> Array:
    """Points (n, 2) of the blank's edge, once around from the tip of the bowl."""
    front, back, across = BOWL
    angle = np.linspace(0.0, 2.55, 14)
    x = BOWL_CENTRE - np.where(angle < np.pi / 2, front, back) * np.cos(angle)
    half = np.concatenate([np.stack([x, across * np.sin(angle)], axis=1), HANDLE])
    other = half[:0:-1] * [1.0, -1.0]
    return np.concatenate([half, [[LENGTH, 0.0]], other])


def _middle_surface(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Height of the pressed sheet's middle surface [m] and its slopes along x and y."""
    front, back, across = BOWL
    ahead = x - BOWL_CENTRE
    along = np.where(ahead < 0.0, front, back)
    inside = RIM**2 * ((ahead / along) ** 2 + (y / across) ** 2)
    # (1 - r^2)^2 meets the flat handle without a crease; at the rim, r = 0.8, it still climbs.
    drop = np.maximum(1.0 - inside, 0.0)
    steep = 4.0 * BOWL_DEPTH * drop * RIM**2
    u = np.maximum(ahead, 0.0) / (LENGTH - BOWL_CENTRE)
    height = RISE * (3.0 * u**2 - 2.4 * u**3) - BOWL_DEPTH * drop**2
    slope = RISE * (6.0 * u - 7.2 * u**2) / (LENGTH - BOWL_CENTRE)
    return height, slope + steep * ahead / along**2, steep * y / across**2


def press(points: Array) -> Array:
    """Carry points (n, 3) of the flat blank, abs(z) <= SHEET / 2, into the shape of the spoon."""
    x, y, depth = points.T
    height, slope_x, slope_y = _middle_surface(x, y)
    normal = np.stack([-slope_x, -slope_y, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=0)
    thicker = (NECK_SHEET / SHEET - 1.0) * np.exp(-(((x - HANDLE[1, 0]) / 0.04) ** 2))
    pressed = np.stack([x, y, height]) + depth * (1.0 + thicker) * normal
    return np.ascontiguousarray(pressed.T)


def _blank(size: float) -> None:
    """Flat blank of sheet, cut across at the neck and where the hand holds it."""
    occ = gmsh.model.occ
    points = [occ.addPoint(x, y, -SHEET / 2) for x, y in _outline()]
    edge = occ.addSpline([*points, points[0]])
    blank = occ.addPlaneSurface([occ.addCurveLoop([edge])])
    cuts = [
        (1, occ.addLine(*(occ.addPoint(x, y, -SHEET / 2) for y in (-0.02, 0.02))))
        for x in (NECK, HELD_FROM)
    ]
    _, (pieces, *lines) = occ.fragment([(2, blank)], cuts)
    layers = max(2, modelling.divisions(SHEET, size))
    occ.extrude(pieces, 0.0, 0.0, SHEET, numElements=[layers])
    occ.synchronize()
    for dimension, tag in [line for cut in lines for line in cut]:
        if len(gmsh.model.getAdjacencies(dimension, tag)[0]) == 0:
            gmsh.model.removeEntities([(dimension, tag)], recursive=True)


def spoon(*, size: modelling.Size = 2.1e-3, order: modelling.Order = 1) -> None:
    """Table spoon along x, the tip of its bowl at the origin, its hollow side up.

    Groups: volume "body"; faces "handle_end" (all faces of the last 35 mm of the handle) and
    "bowl" (the hollow side of the bowl).

    Args:
        size: target edge length in the sheet [m]; there are two cells across it or more.
        order: 1 or 2.

    Raises:
        MeshScriptError: the size is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size)
    _blank(size)
    modelling.name_group(3, "body", [tag for _, tag in gmsh.model.getEntities(3)])
    middle = {tag: gmsh.model.occ.getCenterOfMass(2, tag)[0] for tag in modelling.boundary_faces()}
    held = [tag for tag, x in middle.items() if x > HELD_FROM]
    bowl = [tag for tag in modelling.faces_in_plane("z", SHEET / 2) if middle[tag] < NECK]
    modelling.name_group(2, "handle_end", held)
    modelling.name_group(2, "bowl", bowl)
    modelling.generate(size=size, order=order)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    pressed = press(coordinates.reshape(-1, 3))
    for tag, point in zip(tags, pressed, strict=True):  # gmsh moves one node a call
        gmsh.model.mesh.setNode(tag, point, [])


if __name__ == "__main__":
    raise SystemExit(scripting.run(spoon))
