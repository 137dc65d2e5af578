"""Steel tuning fork that sounds A4 = 440 Hz when it is held at the end of its stem.

The prongs are of round bar with a radius of 2.5 mm, bent with a radius of 7.5 mm: the dimensions
of the "Tuning Fork" model of the COMSOL Multiphysics application library, a steel fork for 440 Hz.
A fork maker files the prongs to pitch; that model tunes the length of their straight part instead
and ends at 79.1 mm (for E = 205 GPa, 7850 kg/m^3). The stem is ours: the text gives no figures.

The tuning was checked here with quadratic cells, the stem's end held, E = 206 GPa, Poisson's ratio
0.29 and 7850 kg/m^3: the mode in which the prongs swing against each other comes at 441.3 Hz with
6,362 nodes (2 mm) and at 440.3 Hz with 36,670 (1 mm), so the length was left alone. It is the
fourth mode: the fork sways on its stem at 126 Hz in both directions, and the prongs wave out of
its plane at 406 Hz.
"""

import math
from typing import Annotated

import gmsh

if __package__:
    from meshes import modelling, scripting
else:  # run as a script: Python has put this folder first on its path
    import modelling  # type: ignore[import-not-found,no-redef]
    import scripting  # type: ignore[import-not-found,no-redef]

BAR = 2.5e-3  # radius of the prongs [m]
BEND = 7.5e-3  # radius of the U's centre line [m]
STEM_RADIUS = 2.2e-3  # thinner than the bar, so that the two meet in one clean curve
STEM = 40.0e-3  # from the lowest point of the bend to the stem's end [m]
PRONG = 79.1e-3  # straight part [m]


def tuning_fork(
    *,
    size: modelling.Size = 2.0e-3,
    order: modelling.Order = 2,
    prong: Annotated[float, "straight part of the prongs: longer is lower [m]"] = PRONG,
) -> None:
    """Two round prongs along z joined by a U bend, on a round stem; the fork lies in the xz plane.

    The prongs start at z = 0 and end at z = prong; the stem ends at z = -BEND - BAR - STEM.
    Groups: volume "body"; faces "stem_end" and "prong_tips".

    Args:
        size: target edge length [m]; the stem's circle has at least six edges whatever it says.
        order: 1 or 2. The pitch needs 2, in the mesh and in the displacement: the straight faces
            of order 1 cut the round prongs down to slimmer ones.
        prong: length of the straight part of each prong [m].

    Raises:
        MeshScriptError: a length is not positive, or the cells would be too many.
    """
    modelling.check_lengths(size=size, prong=prong)
    occ = gmsh.model.occ
    tip = occ.addDisk(BEND, 0.0, prong, BAR, BAR)
    corners = [occ.addPoint(BEND, 0.0, prong), occ.addPoint(BEND, 0.0, 0.0)]
    corners += [occ.addPoint(-BEND, 0.0, 0.0), occ.addPoint(-BEND, 0.0, prong)]
    bottom = occ.addPoint(0.0, 0.0, -BEND)
    path = [
        occ.addLine(corners[0], corners[1]),
        occ.addCircleArc(corners[1], bottom, corners[2], center=False),
        occ.addLine(corners[2], corners[3]),
    ]
    bar = occ.addPipe([(2, tip)], occ.addWire(path))
    occ.remove([(2, tip), *((1, line) for line in path)], recursive=True)
    stem_end = -BEND - BAR - STEM
    stem = occ.addCylinder(0.0, 0.0, stem_end, 0.0, 0.0, -BEND - stem_end, STEM_RADIUS)
    body, _ = occ.fuse(bar, [(3, stem)])
    occ.synchronize()
    modelling.name_group(3, "body", [tag for _, tag in body])
    modelling.name_group(2, "stem_end", modelling.faces_in_plane("z", stem_end))
    modelling.name_group(2, "prong_tips", modelling.faces_in_plane("z", prong))
    modelling.generate(size=min(size, 2.0 * math.pi * STEM_RADIUS / 6), order=order)


if __name__ == "__main__":
    raise SystemExit(scripting.run(tuning_fork))
