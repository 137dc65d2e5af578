"""A solid falls after it has been flattened, scrambled or turned inside out, and recovers.

    python workflows/recovery.py [--output DIR] [--quick]

A free cube of 1 m, rubber of 1 MPa and 1000 kg/m³, of the invertible neo-Hookean law, is let go
under gravity from three shapes: all its nodes in one plane; its nodes anywhere in the cube, by
chance; and its mirror image, where each cell is inside out. Implicit Newmark, one Newton iteration
a step, stiffness damping, no contact.

What is asserted: at the end det F > 0 in each cell, and within 2 % of 1; the volume is back within
0.5 %; all edges have their length again within 3 %; and the centre of mass has fallen g t²/2,
whatever went on within the body. What is left is a slow spin, which stretches the cube: damping by
the tangent of a body under stress does not keep the angular momentum.

The law's stress is continued linearly below a principal stretch, the threshold, and it matters
which. A flattened body recovers with any. One turned inside out or scrambled can come to rest
tangled, some nodes on the wrong side of their neighbours, and more often so with a threshold of 0.1
or 0.3, where the law keeps the barrier of neo-Hooke's that a tangle would have to pass. With 0.9,
near the rest shape, and so little damping that the body shakes, all came free. A body that has
recovered has no stretch below it, and its law is then neo-Hooke's throughout.
"""

import sys
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import common
import numpy as np
from numpy.typing import NDArray

from fenics_defo import analysis, energy, fem

type Array = NDArray[np.float64]

RUBBER = energy.NeoHookean(young=1e6, poisson=0.4, density=1000.0)
THRESHOLD = 0.9
STEP, DURATION, DAMPING = 0.005, 1.0, (0.0, 0.002)
GRAVITY = 9.81
STARTS = ("flattened", "scrambled", "inside out")
SHOWN = (0, 4, 16, 60, -1)  # steps in the figure


@dataclass(frozen=True, slots=True)
class Fall:
    """What was seen of one fall of k steps.

    Args:
        times: (k + 1,) [s].
        smallest: least det F of all cells (k + 1,) [-].
        largest: greatest (k + 1,) [-].
        volume: relative to rest (k + 1,) [-].
        fallen: by the centre of mass (k + 1,) [m].
        edges: largest relative error of an edge's length at the end [-].
        shapes: places of the nodes (k + 1, n, 3) [m].
    """

    times: Array
    smallest: Array
    largest: Array
    volume: Array
    fallen: Array
    edges: float
    shapes: Array

    @property
    def recovered(self) -> float:
        """Time from which on no cell is inverted [s]; infinite if one is at the end."""
        bad = np.flatnonzero(self.smallest <= 0.0)
        after = 0 if bad.size == 0 else int(bad[-1]) + 1
        return float(self.times[after]) if after < len(self.times) else np.inf


def main(argv: list[str] | None = None) -> int:
    """Let three bodies fall, print, draw and check."""
    options = common.parser(__doc__, "recovery").parse_args(argv)
    count = 3 if options.quick else 8
    law = energy.Invertible(RUBBER, threshold=THRESHOLD)
    solid = fem.Solid(common.box((1.0, 1.0, 1.0), (count,) * 3), law)
    falls = {start: fall(solid, start) for start in STARTS}
    common.tell(options.output, "recovery", report(falls, solid), draw(falls, solid))
    check(falls)
    return 0


def start_places(points: Array, start: str) -> Array:
    """Where the nodes begin (n, 3) [m]."""
    places = points.copy()
    if start == "flattened":
        places[:, 2] = 0.0
    elif start == "scrambled":
        places = np.random.default_rng(1).uniform(0.0, 1.0, points.shape)
    else:
        places[:, 2] = 1.0 - points[:, 2]
    return places


def fall(solid: fem.Solid, start: str) -> Fall:
    """One body's fall."""
    points, shapes = solid.points, []

    def see(simulation: analysis.Simulation) -> None:
        shapes.append(points + simulation.state.displacement)

    motion = analysis.simulate(
        solid,
        [analysis.Gravity((0.0, 0.0, -GRAVITY))],
        analysis.ImplicitNewmark(),
        step=STEP,
        duration=DURATION,
        damping=DAMPING,
        initial=analysis.Initial(displacement=start_places(points, start) - points),
        energies_every=0,
        observe=see,
    )
    seen = np.array(shapes)
    rest = volumes(points, solid.cells)
    now = np.array([volumes(shape, solid.cells) for shape in seen])
    mass = solid.lumped_mass() / solid.total_mass()
    height = seen[:, :, 2] @ mass
    return Fall(
        times=motion.times,
        smallest=(now / rest).min(axis=1),
        largest=(now / rest).max(axis=1),
        volume=now.sum(axis=1) / rest.sum(),
        fallen=height[0] - height,
        edges=float(
            np.abs(lengths(seen[-1], solid.cells) / lengths(points, solid.cells) - 1).max()
        ),
        shapes=seen,
    )


def volumes(places: Array, cells: NDArray[np.int64]) -> Array:
    """Signed volumes of tetrahedra (m,) [m³]."""
    corners = places[cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0


def lengths(places: Array, cells: NDArray[np.int64]) -> Array:
    """Lengths of the edges of each tetrahedron (m, 6) [m]."""
    corners = places[cells]
    edges = [corners[:, b] - corners[:, a] for a, b in combinations(range(4), 2)]
    return np.linalg.norm(edges, axis=-1).T


def check(falls: dict[str, Fall]) -> None:
    """What is asserted."""
    for start, seen in falls.items():
        assert seen.smallest[0] <= 1e-12, start  # or there would be nothing to recover from
        assert seen.smallest[-1] > 0.98, (start, seen.smallest[-1])
        assert seen.largest[-1] < 1.02, (start, seen.largest[-1])
        assert abs(seen.volume[-1] - 1.0) < 5e-3, (start, seen.volume[-1])
        assert seen.edges < 0.03, (start, seen.edges)
        law = 0.5 * GRAVITY * seen.times**2
        np.testing.assert_allclose(seen.fallen, law, rtol=0.0, atol=1e-9, err_msg=start)


def report(falls: dict[str, Fall], solid: fem.Solid) -> str:
    """The table as Markdown."""
    columns = (
        "start",
        "least det F at the start",
        "no cell inverted from [s]",
        "det F at the end",
        "volume at the end",
        "largest error of an edge",
        "fallen, error of g t²/2 [m]",
    )
    rows = [
        (
            start,
            f"{seen.smallest[0]:.3g}",
            f"{seen.recovered:.3f}",
            f"{seen.smallest[-1]:.5f} to {seen.largest[-1]:.5f}",
            f"{seen.volume[-1]:.6f}",
            f"{seen.edges:.1e}",
            f"{np.abs(seen.fallen - 0.5 * GRAVITY * seen.times**2).max():.1e}",
        )
        for start, seen in falls.items()
    ]
    return (
        f"# Recovery from collapse: a cube of {len(solid.cells):,} tetrahedra\n\n"
        + common.table(columns, rows)
        + f"\nInvertible neo-Hookean, threshold {THRESHOLD:g}, {DURATION:g} s of fall in steps of "
        + f"{STEP:g} s. Made by `workflows/recovery.py`.\n\n"
        + "![Shapes, det F and volume](recovery.png)\n"
    )


def surface(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Faces of one tetrahedron only (f, 3)."""
    faces = np.concatenate([cells[:, list(face)] for face in combinations(range(4), 3)])
    _, first, times = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[first[times == 1]]


def draw(falls: dict[str, Fall], solid: fem.Solid) -> Any:
    """The scrambled body at a few times; least det F and volume of all."""
    figure, grid = common.new_figure(2, len(SHOWN), (11.0, 5.6))
    faces, seen = surface(solid.cells), falls["scrambled"]
    for i, step in enumerate(SHOWN):
        grid[0, i].remove()
        axes = figure.add_subplot(2, len(SHOWN), i + 1, projection="3d")
        x, y, z = (seen.shapes[step] - seen.shapes[step].mean(axis=0)).T
        axes.plot_trisurf(x, y, z, triangles=faces, color="C0", edgecolor="k", linewidth=0.2)
        axes.set(xlim=(-0.6, 0.6), ylim=(-0.6, 0.6), zlim=(-0.6, 0.6))
        axes.set_title(f"{seen.times[step]:.3f} s", fontsize=9)
        axes.set_axis_off()
    for axes in grid[1]:
        axes.remove()
    below = [figure.add_subplot(2, 2, 3), figure.add_subplot(2, 2, 4)]
    for start, one in falls.items():
        below[0].plot(one.times, one.smallest, label=start)
        below[1].plot(one.times, one.volume, label=start)
    below[0].set(xlabel="time [s]", ylabel="least det F", yscale="symlog")
    below[1].set(xlabel="time [s]", ylabel="volume / volume at rest", ylim=(-1.1, 2.0))
    for axes in below:
        axes.grid(alpha=0.3)
    below[0].legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
