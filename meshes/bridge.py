"""Open-spandrel deck-arch bridge with a span of 20 m, of concrete by its proportions.

Two parabolic ribs rise 4 m and carry the deck on columns; cross-beams tie the ribs together.
Sizes that give a series of bodies at order 1, with three degrees of freedom a node (gmsh 4.15):

    size [m]   nodes     dofs
    0.48        3,254     9,762
    0.24       10,093    30,279
    0.14       33,777   101,331
    0.09       99,338   298,014
"""

import gmsh
import numpy as np

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

SPAN = 20.0  # between the springings' centre lines [m]
RISE = 4.0  # of the ribs' centre line [m]
RIB_DEPTH = 0.7  # of a rib, measured across its centre line [m]
RIB_WIDTH = 0.6  # [m]
RIB_AT = 1.3  # distance of a rib's middle plane from the bridge's [m]
DECK_LENGTH = 24.0  # [m]
DECK_WIDTH = 4.0  # [m]
DECK_DEPTH = 0.35  # [m]
KERB = 0.25  # width and height of the kerbs [m]
COLUMN = 0.4  # side of the columns along the bridge [m]
COLUMNS_AT = (-9.0, -7.0, -5.0, 5.0, 7.0, 9.0)  # along the bridge [m]
BEAMS_AT = (-7.0, -3.5, 3.5, 7.0)  # cross-beams between the ribs, along the bridge [m]
DECK_BOTTOM = RISE + RIB_DEPTH / 2 - 0.1  # the crown of the ribs is let into the deck [m]
DECK_TOP = DECK_BOTTOM + DECK_DEPTH

type Entity = tuple[int, int]


def _arch_height(x: float) -> float:
    return RISE * (1.0 - (2.0 * x / SPAN) ** 2)


def _rib(y: float) -> Entity:
    """Rib of constant depth about the parabola, its ends cut along the normals of the parabola."""
    occ = gmsh.model.occ
    x = np.linspace(-SPAN / 2, SPAN / 2, 17)
    centre = np.stack([x, RISE * (1.0 - (2.0 * x / SPAN) ** 2)])
    slope = -8.0 * RISE * x / SPAN**2
    normal = np.stack([-slope, np.ones_like(slope)]) / np.hypot(1.0, slope)
    edges = []
    for offset in (-RIB_DEPTH / 2, RIB_DEPTH / 2):
        points = [occ.addPoint(a, y - RIB_WIDTH / 2, b) for a, b in (centre + offset * normal).T]
        edges.append((occ.addSpline(points), points[0], points[-1]))
    (lower, lower_start, lower_end), (upper, upper_start, upper_end) = edges
    left = occ.addLine(lower_start, upper_start)
    right = occ.addLine(lower_end, upper_end)
    section = occ.addPlaneSurface([occ.addCurveLoop([lower, right, -upper, -left])])
    solid = next(e for e in occ.extrude([(2, section)], 0.0, RIB_WIDTH, 0.0) if e[0] == 3)
    return solid


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Entity:
    return 3, gmsh.model.occ.addBox(*low, *(b - a for a, b in zip(low, high, strict=True)))


def _side(y: float) -> list[Entity]:
    """A rib at ``y`` with its columns, and the kerb above it."""
    half = RIB_WIDTH / 2
    columns = [
        _box(
            (x - COLUMN / 2, y - half, _arch_height(x)),
            (x + COLUMN / 2, y + half, DECK_BOTTOM + DECK_DEPTH / 2),
        )
        for x in COLUMNS_AT
    ]
    edge = np.sign(y) * DECK_WIDTH / 2
    inner = edge - np.sign(y) * KERB
    kerb = _box(
        (-DECK_LENGTH / 2, min(edge, inner), DECK_BOTTOM),
        (DECK_LENGTH / 2, max(edge, inner), DECK_TOP + KERB),
    )
    return [_rib(y), *columns, kerb]


def _cross_beams() -> list[Entity]:
    side = RIB_DEPTH / 4
    return [
        _box(
            (x - side, -RIB_AT, _arch_height(x) - side), (x + side, RIB_AT, _arch_height(x) + side)
        )
        for x in BEAMS_AT
    ]


def bridge(*, size: modelling.Size = 0.3, order: modelling.Order = 1) -> None:
    """Deck-arch bridge along x, its springings' centre lines at z = 0 and x = -10 m and 10 m.

    Groups: volume "body"; faces "abutments" (the ends of the ribs, and both ends of the deck) and
    "deck" (the top of the deck between the kerbs).

    Args:
        size: target edge length [m].
        order: 1 or 2.

    Raises:
        MeshScriptError: the size is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size)
    deck = _box(
        (-DECK_LENGTH / 2, -DECK_WIDTH / 2, DECK_BOTTOM),
        (DECK_LENGTH / 2, DECK_WIDTH / 2, DECK_TOP),
    )
    parts = [*_side(-RIB_AT), *_side(RIB_AT), *_cross_beams()]
    body, _ = gmsh.model.occ.fuse([deck], parts)
    gmsh.model.occ.synchronize()
    modelling.name_group(3, "body", [tag for _, tag in body])
    ends = [
        face
        for x in (-DECK_LENGTH / 2, DECK_LENGTH / 2)
        for face in modelling.faces_in_plane("x", x)
    ]
    modelling.name_group(2, "abutments", ends + _springings())
    modelling.name_group(2, "deck", modelling.faces_in_plane("z", DECK_TOP))
    modelling.generate(size=size, order=order)


def _springings() -> list[int]:
    """The two end faces of each rib: those that reach below every other face."""
    return [
        tag
        for tag in modelling.boundary_faces()
        if abs(gmsh.model.occ.getCenterOfMass(2, tag)[2]) < 1.0e-6
    ]


if __name__ == "__main__":
    raise SystemExit(scripting.run(bridge))
