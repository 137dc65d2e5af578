"""An end-loaded cantilever bent far: cubic forces and cubature beside the full simulation.

    python workflows/cantilever.py [--output DIR] [--quick]

A slender beam is pulled sideways at its end by a dead load that comes up within a third of its
period and stays: it swings until its end has turned by more than 60 degrees. The materials have the
same moduli at rest: St. Venant-Kirchhoff's, whose reduced force is a cubic polynomial exactly,
neo-Hookean and Mooney-Rivlin, whose reduced forces are sums over few weighted points (cubature).
St. Venant-Kirchhoff is run through cubature too, beside the cubic force of the same basis. Beside
the other two stands the unreduced Galerkin force, so that the error of the points is seen apart
from that of the basis.

What is asserted: modes alone fail, with a linear force and with the exact one; with their
derivatives, which are those of the rest shape, the first swing is followed within some per cent,
and later ones, as the period is a little off, within twice that; a basis of the motion's own frames
follows it within less than one per cent; cubature changes the motion by less than the basis does,
and the less the more points it has; the number of points that a tolerance needs grows as the number
of coordinates.
"""

import sys
from dataclasses import dataclass
from typing import Any

import beside_full
import common
import numpy as np
from numpy.typing import NDArray

from fenics_defo import analysis, energy, fem, reduction

type Array = NDArray[np.float64]

LENGTH, WIDTH, HEIGHT = 1.0, 0.1, 0.05  # [m]
YOUNG, POISSON, DENSITY = 1e7, 0.4, 1000.0
PULL = 4000.0  # [Pa] on the end
TOLERANCE = 0.01  # of cubature
STVK, NEO, RIVLIN = "St. Venant-Kirchhoff", "neo-Hookean", "Mooney-Rivlin"


@dataclass(frozen=True, slots=True)
class Size:
    """How much is computed.

    Args:
        cells: bricks along x, y and z, of six tetrahedra each.
        steps: of the motion.
        modes: k of them.
        r: columns of the basis.
        points: at which cubatures are stopped.
        ranks: numbers of columns for which points are counted.
    """

    cells: tuple[int, int, int]
    steps: int
    modes: int
    r: int
    points: tuple[int, ...]
    ranks: tuple[int, ...]


FULL = Size((24, 2, 2), 200, 6, 15, (10, 15, 20, 30, 50, 80, 120), (5, 10, 15, 20, 27))
QUICK = Size((10, 1, 1), 60, 4, 8, (8, 30), (4, 8))


def laws() -> dict[str, Any]:
    """Materials of the same moduli at rest."""
    constants = {"young": YOUNG, "poisson": POISSON, "density": DENSITY}
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    return {
        STVK: energy.StVenantKirchhoff(**constants),
        NEO: energy.NeoHookean(**constants),
        RIVLIN: energy.MooneyRivlin(
            c10=0.3 * shear,
            c01=0.2 * shear,
            bulk=YOUNG / (3.0 * (1.0 - 2.0 * POISSON)),
            density=DENSITY,
        ),
    }


def story(law: Any, size: Size) -> beside_full.Story:
    """The cantilever of a material."""
    body = common.box((LENGTH, WIDTH, HEIGHT), size.cells)
    solid = fem.Solid(body, law, order=2, fixed=["x<1e-9"])
    pull = analysis.Traction(
        f"x>{0.999 * LENGTH}", (0.0, 0.0, -PULL), history=analysis.Table((0.0, 0.4), (0.0, 1.0))
    )
    return beside_full.Story(
        solid=solid,
        loads={"pull": pull},
        step=0.015,
        steps=size.steps,
        damping=(0.2, 1e-3),
        watched=(LENGTH, 0.5 * WIDTH, 0.5 * HEIGHT),
        newton=3,
        every=2,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Chapter:
    """A material's motion.

    Args:
        told: its story.
        full: the full run.
        modes: of the body.
        basis: of modes and their derivatives.
        exact: the reduced run by the force that is exact within the basis.
        summed: that by cubature.
        others: more reduced runs.
    """

    told: beside_full.Story
    full: beside_full.Full
    modes: Any
    basis: reduction.Basis
    exact: beside_full.Reduced
    summed: beside_full.Reduced
    others: tuple[beside_full.Reduced, ...] = ()

    @property
    def runs(self) -> list[beside_full.Reduced]:
        """All reduced runs."""
        return [*self.others, self.exact, self.summed]

    @property
    def apart(self) -> float:
        """What the points change of the motion within the basis [-]."""
        return between(self.summed, self.exact)


def main(argv: list[str] | None = None) -> int:
    """Run all, print, draw and check."""
    options = common.parser(__doc__, "cantilever").parse_args(argv)
    size = QUICK if options.quick else FULL
    chapters = {name: chapter(name, law, size) for name, law in laws().items()}
    curves = {name: curve(chapters[name], size) for name in (STVK, NEO)}
    counts = counted(chapters[NEO], size)
    text, figure = report(chapters, counts), draw(chapters, curves, counts)
    common.tell(options.output, "cantilever", text, figure)
    check(chapters, curves, counts)
    return 0


def between(one: beside_full.Reduced, other: beside_full.Reduced) -> float:
    """Largest distance of two motions within one orthonormal basis, over the other's largest."""
    norms = [np.linalg.norm(q, axis=1).max() for q in (one.q - other.q, other.q)]
    return float(norms[0] / norms[1])


def chapter(name: str, law: Any, size: Size) -> Chapter:
    """The full run of a material, and the reduced ones."""
    told = story(law, size)
    full = beside_full.run_full(told)
    modes = analysis.linear_modes(told.solid, size.modes, verify=False)
    basis = reduction.modal_derivative_basis(told.solid, modes, size=size.r)

    def run(title: str, force: str, basis: reduction.Basis = basis) -> beside_full.Reduced:
        model, seconds = beside_full.model_of(told, basis, force)
        title = f"{name}, {title}".replace("#", f"{model.certificate['force'].get('points')}")
        return beside_full.run_reduced(told, title, model, seconds, full)

    exact = "cubic" if name == STVK else "direct"
    linear = reduction.linear_basis(told.solid, modes)
    own = reduction.snapshot_basis(told.solid, full.frames, size=size.r)
    others = {
        STVK: (
            (f"linear, {size.modes} modes", "linear", linear),
            (f"cubic, {size.modes} modes", "cubic", linear),
            (f"cubic, r = {size.r}, the motion's own frames", "cubic", own),
        ),
    }
    return Chapter(
        told,
        full,
        modes,
        basis,
        run(f"{exact}, r = {size.r}", exact),
        run(f"cubature of # points, r = {size.r}", "cubature"),
        tuple(run(*other) for other in others.get(name, ())),
    )


def curve(about: Chapter, size: Size) -> Array:
    """Rows (points, held-out error of the force, change of the motion) of more and more points."""
    found = []
    for most in size.points:
        training = reduction.train_cubature(
            about.told.solid, about.basis.shapes, tolerance=1e-4, most=most
        )
        model, _ = beside_full.model_of(about.told, about.basis, "cubature", training=training)
        run = beside_full.run_reduced(about.told, f"{most}", model, 0.0, about.full)
        found.append((training.points, training.held_out_error, between(run, about.exact)))
    return np.array(found)


def counted(about: Chapter, size: Size) -> Array:
    """Rows (r, points to the tolerance, held-out error) of bases of several sizes."""
    found = []
    for r in size.ranks:
        basis = reduction.modal_derivative_basis(about.told.solid, about.modes, size=r)
        training = reduction.train_cubature(about.told.solid, basis.shapes, tolerance=TOLERANCE)
        found.append((r, training.points, training.held_out_error))
    return np.array(found)


def turn(about: Chapter) -> float:
    """Largest angle by which the section at the end turns [degrees]."""
    points = about.told.solid.points
    lines = [
        int(np.argmin(np.linalg.norm(points - (LENGTH, 0.5 * WIDTH, z), axis=1)))
        for z in (0.0, HEIGHT)
    ]
    ends = points[lines] + about.full.frames[:, lines]
    along = ends[:, 1] - ends[:, 0]
    return float(np.degrees(np.arctan2(along[:, 0], along[:, 2])).max())


def report(chapters: dict[str, Chapter], counts: Array) -> str:
    """The tables as Markdown."""
    first = chapters[STVK]
    parts = [
        "# A cantilever bent far\n",
        beside_full.setting(first.told),
        f"The end of the beam of {LENGTH:g} m moves by {first.full.farthest:.2f} m and turns by "
        f'{turn(first):.0f} degrees. "direct" is the Galerkin force of the whole body.\n',
    ]
    parts += [beside_full.run_table(one.told, one.full, one.runs) for one in chapters.values()]
    rows = [(name, f"{100 * one.apart:.2f} %") for name, one in chapters.items()]
    parts += [
        f"What cubature to {100 * TOLERANCE:g} % of the force changes of the motion within the "
        "basis:\n",
        common.table(("material", "largest change"), rows),
        f"Points that {NEO} needs for {100 * TOLERANCE:g} % at the training poses:\n",
        common.table(
            ("r", "points", "error at held-out poses"),
            [(f"{r:.0f}", f"{points:.0f}", f"{100 * e:.2f} %") for r, points, e in counts],
        ),
        "Made by `workflows/cantilever.py`.\n",
        "![Motion, errors and points](cantilever.png)\n",
    ]
    return "\n".join(parts)


def draw(chapters: dict[str, Chapter], curves: dict[str, Array], counts: Array) -> Any:
    """Paths, errors over time, error against points, points against coordinates."""
    figure, axes = common.new_figure(2, 2, (12.0, 8.5))
    (paths, errors), (points, ranks) = axes
    first = chapters[STVK]
    beside_full.draw_paths(paths, first.full, first.runs, 2)
    paths.set(xlabel="time [s]", ylabel="height of the end [mm]", title=STVK)
    runs = [run for one in chapters.values() for run in one.runs]
    beside_full.draw_errors(errors, first.full, runs)
    errors.set(xlabel="time [s]", ylim=(1e-6, None))
    beside_full.one_legend(figure, errors, columns=3)
    for (name, curve), colour in zip(curves.items(), ("C0", "C1"), strict=True):
        points.loglog(curve[:, 0], curve[:, 2], "o-", color=colour, label=f"{name}, the motion")
        points.loglog(
            curve[:, 0], curve[:, 1], "s:", color=colour, mfc="none", label=f"{name}, the force"
        )
    points.set(xlabel="points of the cubature", ylabel="error within the basis [-]")
    points.legend(fontsize=8)
    ranks.plot(counts[:, 0], counts[:, 1], "o-", label=f"{NEO}, {100 * TOLERANCE:g} % of the force")
    ranks.set(xlabel="coordinates r", ylabel="points", xlim=(0, None), ylim=(0, None))
    ranks.legend(fontsize=8)
    for each in (points, ranks):
        each.grid(alpha=0.3, which="both")
    return figure


def check(chapters: dict[str, Chapter], curves: dict[str, Array], counts: Array) -> None:
    """What is asserted."""
    assert turn(chapters[STVK]) > 60.0, turn(chapters[STVK])
    linear, stiff, own = (run.largest_error for run in chapters[STVK].others)
    assert linear > 0.3, linear
    assert stiff > 0.3, stiff
    assert own < 0.01, own
    for name, one in chapters.items():
        assert beside_full.linearisation(one.told, one.summed) < 1e-3, name
        assert one.exact.largest_error < 0.15, (name, one.exact.largest_error)
        assert one.summed.largest_error < 0.15, (name, one.summed.largest_error)
        assert one.apart < 0.02, (name, one.apart)
    for name, curve in curves.items():
        assert curve[-1, 2] < 0.2 * curve[0, 2], (name, curve)
    needed = counts[:, 1] / counts[:, 0]
    assert needed.max() < 10.0, counts
    assert needed.max() < 2.5 * needed.min(), counts


if __name__ == "__main__":
    sys.exit(main())
