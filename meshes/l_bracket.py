"""Steel L-bracket with two bolt holes in its upright leg and a fillet in the inner corner."""

from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

LEG = 0.100  # outer length of either leg [m]
WIDTH = 0.060  # along y [m]
SHEET = 8.0e-3  # thickness of the legs [m]
BOLT = 4.5e-3  # radius of the holes: clearance holes for M8 bolts [m]
BOLTS_AT = (-15.0e-3, 15.0e-3)  # middles of the holes along y [m]
BOLT_HEIGHT = 0.070  # of the middles above the outer side of the lying leg [m]

type Entity = tuple[int, int]


def _profile(fillet: float) -> Entity:
    """The L of constant thickness in the plane y = -WIDTH / 2, its inner corner rounded."""
    occ = gmsh.model.occ
    y = -WIDTH / 2
    corner = SHEET + fillet
    outline = [(0.0, 0.0), (LEG, 0.0), (LEG, SHEET), (corner, SHEET), (SHEET, corner)]
    outline += [(SHEET, LEG), (0.0, LEG)]
    points = [occ.addPoint(x, y, z) for x, z in outline]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    occ.remove([(1, lines[3])])
    lines[3] = occ.addCircleArc(points[3], occ.addPoint(corner, y, corner), points[4])
    return 2, occ.addPlaneSurface([occ.addCurveLoop(lines)])


def l_bracket(
    *,
    size: modelling.Size = 4.0e-3,
    order: modelling.Order = 1,
    fillet: Annotated[float, "radius in the inner corner, at most 0.05 [m]"] = 8.0e-3,
) -> None:
    """L-bracket: one leg lies along x, the other stands along z against the wall at x = 0.

    Groups: volume "body"; faces "bolts" (the round walls of both holes) and "load_face" (the top
    of the lying leg).

    Args:
        size: target edge length [m], SHEET at most; a full circle has at least twelve edges.
        order: 1 or 2.
        fillet: radius in the inner corner [m], at most 0.05.

    Raises:
        MeshScriptError: a length is not allowed, or the cells would be too many.
    """
    modelling.check_lengths(size=size, fillet=fillet)
    if not fillet <= 0.05:
        raise modelling.MeshScriptError(
            f"fillet {fillet} m would reach the bolt holes; give at most 0.05 m."
        )
    occ = gmsh.model.occ
    solid = next(e for e in occ.extrude([_profile(fillet)], 0.0, WIDTH, 0.0) if e[0] == 3)
    holes = [
        (3, occ.addCylinder(-SHEET, y, BOLT_HEIGHT, 3.0 * SHEET, 0.0, 0.0, BOLT)) for y in BOLTS_AT
    ]
    body, _ = occ.cut([solid], holes)
    occ.synchronize()
    modelling.name_group(3, "body", [tag for _, tag in body])
    round_walls = [
        tag
        for tag in modelling.boundary_faces()
        if abs(occ.getCenterOfMass(2, tag)[2] - BOLT_HEIGHT) < BOLT / 2
        and gmsh.model.getType(2, tag) == "Cylinder"
    ]
    modelling.name_group(2, "bolts", round_walls)
    modelling.name_group(2, "load_face", modelling.faces_in_plane("z", SHEET))
    modelling.generate(size=min(size, SHEET), order=order, circle_cells=12)


if __name__ == "__main__":
    raise SystemExit(scripting.run(l_bracket))
