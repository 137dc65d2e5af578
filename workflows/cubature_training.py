"""Ways to train a cubature, judged by points, by errors and by motions that nobody trained for.

    python workflows/cubature_training.py [--output DIR] [--quick]

A clamped beam 4 x 1 x 1 m falls sideways under gravity and swings, bending far over its
length. Its reduced motion with the exact force U^T f(U q) is the judge of cubatures of the same
basis:

- three methods: greedy from random subsets (An, Kim and James 2008), sparse non-negative least
  squares over all candidates as in ECSW (Farhat et al. 2014), and thinned, which adds points with
  orthogonal projection and takes those away again that are not needed;
- two clouds of poses: random coordinates scaled by frequency, and equilibria under random loads;
- St. Venant-Kirchhoff, whose exact force is cubic: its error against the number of points.

What is asserted: thinned needs the fewest points; equilibria serve the motion better than random
coordinates; the motion's error falls as points are added; each training keeps its promise on poses
held out.
"""

import sys
import time
from dataclasses import dataclass
from typing import Any

import common
import numpy as np
from cubature_timings import Beam
from numpy.typing import NDArray

from fenics_defo import energy, reduction, runtime
from fenics_defo.reduction.reducing import ForceKind

type Array = NDArray[np.float64]
type Row = dict[str, Any]

STVK = energy.StVenantKirchhoff(young=1e6, poisson=0.4, density=1000.0)
PULL = (0.0, 0.5, -2.0)
STEP = 0.02
METHODS = ("thinned", "greedy", "ecsw")
CLOUDS = ("statics", "sampled")


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """The motion with the exact reduced force.

    Args:
        beam: body and basis.
        model: with the exact force.
        path: coordinates (k, r).
        forces: exact (k, r) on the path.
    """

    beam: Beam
    model: runtime.ReducedModel
    path: Array
    forces: Array

    @classmethod
    def of(cls, beam: Beam, force: ForceKind, steps: int) -> "Judge":
        """Judge by a force that is exact for the beam's law: "cubic" or "direct"."""
        model = reduction.reduce(beam.solid, beam.basis, force)
        path = swing(model, steps)
        return cls(beam, model, path, np.array([model.force(q) for q in path]))

    def errors(self, model: runtime.ReducedModel) -> tuple[float, float]:
        """Of the force on the path, root mean square, and of the model's own motion [-]."""
        apart = np.linalg.norm(model.force(self.path) - self.forces, axis=1)
        relative = apart / np.linalg.norm(self.forces, axis=1)
        own = np.linalg.norm(swing(model, len(self.path)) - self.path, axis=1)
        largest = np.linalg.norm(self.path, axis=1).max()
        return float(np.sqrt((relative**2).mean())), float(own.max() / largest)


def swing(model: runtime.ReducedModel, steps: int) -> Array:
    """The fall from rest (k, r)."""
    motion = runtime.ImplicitNewmark(model, step=STEP, newton=3)
    load, path = model.gravity(PULL), []
    for _ in range(steps):
        motion.advance(load)
        path.append(motion.q)
    return np.array(path)


def main(argv: list[str] | None = None) -> int:
    """Train, judge, print, draw and check."""
    options = common.parser(__doc__, "cubature_training").parse_args(argv)
    quick = options.quick
    cells, r, steps = ((8, 2, 2), 6, 60) if quick else ((24, 6, 6), 20, 150)
    tolerances = (0.05, 0.02) if quick else (0.05, 0.02, 0.01)
    rubber = Judge.of(Beam.of(cells, r), "direct", steps)
    rows = [
        row_of(rubber, method, cloud, tolerance)
        for method, cloud in (*((m, "statics") for m in METHODS), ("thinned", "sampled"))
        for tolerance in tolerances
    ]
    stiff = Judge.of(Beam.of(cells, r, STVK), "cubic", steps)
    counts = (8, 16, 24) if quick else (10, 20, 40, 60, 80, 120)
    exact = [points_row(stiff, count) for count in counts]
    bend = float(np.abs(rubber.model.displacement(rubber.path)).max())
    text = report(rows, exact, bend, rubber.model.size)
    common.tell(options.output, "cubature_training", text, draw(rows, exact))
    check(rows, exact, bend)
    return 0


def row_of(judge: Judge, method: str, cloud: str, tolerance: float) -> Row:
    """One training and what the motion says of it."""
    begin = time.process_time()
    model, training = judge.beam.trained(tolerance, method=method, poses=cloud)
    seconds = time.process_time() - begin
    on_path, motion = judge.errors(model)
    return {
        "method": method,
        "poses": cloud,
        "tolerance": tolerance,
        "points": training.points,
        "training": training.training_error,
        "held_out": training.held_out_error,
        "rest": training.rest_error,
        "seconds": seconds,
        "on_path": on_path,
        "motion": motion,
        "curve": training.curve,
    }


def points_row(judge: Judge, count: int) -> Row:
    """St. Venant-Kirchhoff with so many points."""
    model, training = judge.beam.trained(1e-6, most=count)
    on_path, motion = judge.errors(model)
    held_out = training.held_out_error
    return {"points": training.points, "held_out": held_out, "on_path": on_path, "motion": motion}


def report(rows: list[Row], exact: list[Row], bend: float, r: int) -> str:
    """All that was found."""
    lines = [
        [
            row["method"],
            row["poses"],
            f"{row['tolerance']:.0%}",
            str(row["points"]),
            *(f"{row[name]:.2%}" for name in ("held_out", "rest", "on_path", "motion")),
            f"{row['seconds']:.1f}",
        ]
        for row in rows
    ]
    columns = ["method", "poses", "asked", "points", "held out", "frequencies at rest"]
    columns += ["force on the motion", "motion", "training [s]"]
    text = (
        "# Training a cubature\n\n"
        f"A neo-Hookean beam, r = {r}, falls and bends by {bend:.2g} m of 4 m. Errors: of the "
        "force at held-out poses, of the frequencies at rest (largest), of the force along the "
        "motion (root mean square, relative), and of the motion itself (largest, over its largest "
        "coordinates), against the same basis with the exact force. Processor time.\n\n"
    )
    text += common.table(columns, lines)
    lines = [
        [str(row["points"]), *(f"{row[name]:.2%}" for name in ("held_out", "on_path", "motion"))]
        for row in exact
    ]
    columns = ["points", "held out", "force on the motion", "motion"]
    return (
        text
        + "\n## St. Venant-Kirchhoff against its exact cubic force\n\n"
        + common.table(columns, lines)
        + "\n![Errors against points](cubature_training.png)\n"
    )


def draw(rows: list[Row], exact: list[Row]) -> Any:
    """Errors against points."""
    figure, (left, right) = common.new_figure(1, 2, (11.0, 4.2))
    finest = min(row["tolerance"] for row in rows)
    for color, row in enumerate(row for row in rows if row["tolerance"] == finest):
        name = f"{row['method']}, {row['poses']}"
        curve = row["curve"]
        left.semilogy(curve.points, curve.held_out, f"C{color}-", label=name)
        left.semilogy(row["points"], row["held_out"], f"C{color}o")
    left.set(xlabel="points", ylabel="held-out error [-]", title="neo-Hookean")
    points = [row["points"] for row in exact]
    for name, label in (
        ("held_out", "held out"),
        ("on_path", "force on the motion"),
        ("motion", "motion"),
    ):
        right.semilogy(points, [row[name] for row in exact], "o-", label=label)
    right.set(xlabel="points", ylabel="error [-]", title="St. Venant-Kirchhoff")
    for axes in (left, right):
        axes.grid(which="both", alpha=0.3)
        axes.legend(fontsize=8)
    return figure


def check(rows: list[Row], exact: list[Row], bend: float) -> None:
    """What is asserted."""
    assert bend > 0.5, bend

    def found(method: str, poses: str, tolerance: float) -> Row:
        wanted = (method, poses, tolerance)
        return next(r for r in rows if (r["method"], r["poses"], r["tolerance"]) == wanted)

    for tolerance in {row["tolerance"] for row in rows}:
        thinned, greedy, ecsw = (found(method, "statics", tolerance) for method in METHODS)
        assert thinned["points"] <= min(greedy["points"], ecsw["points"]), rows
        sampled = found("thinned", "sampled", tolerance)
        assert thinned["on_path"] < sampled["on_path"], rows
    for row in rows:
        assert row["training"] <= row["tolerance"], row
        assert row["held_out"] <= 2.0 * row["tolerance"], row
    assert exact[-1]["on_path"] < 0.5 * exact[0]["on_path"], exact
    assert exact[-1]["motion"] < 0.5 * exact[0]["motion"], exact


if __name__ == "__main__":
    sys.exit(main())
