"""Round plastic basket, 160 mm high, whose wall is woven-looking: rows of staggered slots."""

import math

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

HEIGHT = 0.160  # [m]
BOTTOM_RADIUS = 0.095  # outside, at z = 0 [m]
RIM_RADIUS = 0.130  # outside, at the top of the wall [m]
WALL = 4.0e-3  # thickness of the wall and the bottom, measured across the axis and along it [m]
LIP = 8.0e-3  # how far the rim stands out, and its height [m]
AROUND = 20  # slots in a row
ROWS = 4
SLOT_HEIGHT = 0.020  # [m]
FIRST_ROW = 0.030  # middle of the lowest row [m]
PITCH = 0.032  # from row to row [m]
SLOT_SHARE = 0.6  # width of a slot over the distance from slot to slot [-]

type Entity = tuple[int, int]


def _cup() -> Entity:
    """The basket without slots: a section in the xz plane, turned about the z axis."""
    occ = gmsh.model.occ
    inner_bottom = BOTTOM_RADIUS - WALL + (RIM_RADIUS - BOTTOM_RADIUS) * WALL / HEIGHT
    section = [
        (0.0, 0.0),
        (BOTTOM_RADIUS, 0.0),
        (RIM_RADIUS - (RIM_RADIUS - BOTTOM_RADIUS) * LIP / HEIGHT, HEIGHT - LIP),
        (RIM_RADIUS + LIP, HEIGHT - LIP),
        (RIM_RADIUS + LIP, HEIGHT),
        (RIM_RADIUS - WALL, HEIGHT),
        (inner_bottom, WALL),
        (0.0, WALL),
    ]
    points = [occ.addPoint(x, 0.0, z) for x, z in section]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    turned = occ.revolve([(2, face)], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0 * math.pi)
    return next(entity for entity in turned if entity[0] == 3)


def _slots() -> list[Entity]:
    """Boxes that reach from inside the cup through its wall, each second row turned half a step."""
    occ = gmsh.model.occ
    step = 2.0 * math.pi / AROUND
    boxes = []
    for row in range(ROWS):
        z = FIRST_ROW + row * PITCH
        radius = BOTTOM_RADIUS + (RIM_RADIUS - BOTTOM_RADIUS) * z / HEIGHT
        width = SLOT_SHARE * radius * step
        for column in range(AROUND):
            box = occ.addBox(
                radius / 2, -width / 2, z - SLOT_HEIGHT / 2, radius, width, SLOT_HEIGHT
            )
            occ.rotate([(3, box)], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, (column + row % 2 / 2) * step)
            boxes.append((3, box))
    return boxes


def basket(*, size: modelling.Size = 5.0e-3, order: modelling.Order = 1) -> None:
    """Conical basket about the z axis, its bottom on z = 0, with 80 slots in its wall.

    Groups: volume "body"; faces "rim" (the top of the lip) and "bottom" (on which it stands).

    Args:
        size: target edge length [m], four times WALL at most.
        order: 1 or 2.

    Raises:
        MeshScriptError: the size is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size)
    body, _ = gmsh.model.occ.cut([_cup()], _slots())
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "body", [tag for _, tag in body])
    modelling.name_group(2, "rim", modelling.faces_in_plane("z", HEIGHT))
    modelling.name_group(2, "bottom", modelling.faces_in_plane("z", 0.0))
    for dimension, face in gmsh.model.getEntities(2):
        # Delaunay: the frontal method needs ten times as long for a cone with eighty holes.
        gmsh.model.mesh.setAlgorithm(dimension, face, 5)
    modelling.generate(size=min(size, 4.0 * WALL), order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(basket))
