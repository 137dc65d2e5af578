"""Microseconds of a step with cubature, the time of its training, and the crossover with cubic.

    python workflows/benchmark_cubature.py [--output DIR] [--quick] [--sizes 10,20,30]

A clamped neo-Hookean beam 4 x 1 x 1 m is reduced to r modes and modal derivatives, and its cubature
trained to 5 % and 1 % with the default poses and method. Force, force and tangent, and a step of
implicit Newmark with one Newton iteration are timed for one body and for batches. The floor is the
two matrix products through the point gradients, A G (a 9 x 9 by 9 x r product for each point) and
(w G)^T (A G), with all else for nothing. Beside them stands the step with an exact cubic force of
the same r, whose time does not depend on its coefficients: where the lines cross, cubature becomes
the cheaper one of the two even for St. Venant-Kirchhoff, for which cubic needs no training.

All times are those of this process's processor time with one thread, the least of several rounds
in which the things compared take turns.

What is asserted: held-out errors are within twice the tolerances; more coordinates need more
points, and 1 % more than 5 %; a step costs no more than its force and tangent, its solve and some
calls of NumPy; bodies of a batch are cheaper than single ones.
"""

import platform
import sys
from collections.abc import Sequence
from typing import Any

import common
import cubature_timings as timings
import numpy as np

type Row = dict[str, Any]

TOLERANCES = (0.05, 0.01)
SIZES = (10, 20, 30, 50, 70, 100)
BATCHES = (1, 64, 512)
CELLS = (24, 6, 6)  # six tetrahedra each
#: (r, bodies, tolerance) -> largest allowed microseconds of a step.
GOALS = {(30, 1, 0.01): 250.0, (50, 1, 0.01): 1000.0, (30, 512, 0.01): 80e3}
#: (bricks, r, poses, goal [s]) of trainings to 1 %.
TRAININGS = (
    ((48, 16, 11), 30, 100, 20.0),
    ((24, 16, 11), 30, 100, None),
    ((96, 16, 11), 30, 100, None),
    ((48, 16, 11), 30, 200, None),
    ((48, 16, 11), 15, 100, None),
)


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark."""
    parser = common.parser(__doc__, "benchmark_cubature")
    parser.add_argument("--sizes", default="", help="numbers of coordinates, separated by commas")
    options = parser.parse_args(argv)
    quick = options.quick
    sizes = tuple(int(r) for r in options.sizes.split(",") if r) or ((4, 8) if quick else SIZES)
    seconds = 0.002 if quick else 0.05
    cells = (8, 2, 2) if quick else CELLS
    batches = (1, 8) if quick else BATCHES
    steps, cubic = [], []
    for r in sizes:
        body = timings.Beam.of(cells, r)
        for tolerance in TOLERANCES:
            model, training = body.trained(tolerance)
            steps += [
                timings.step_row(model, training, bodies, seconds=seconds) for bodies in batches
            ]
        cubic.append(timings.cubic_row(r, seconds=seconds))
    trainings = timings.TINY_TRAININGS if quick else TRAININGS
    rows = [timings.training_row(*row) for row in ([] if options.sizes else trainings)]
    parts = [introduction(cells), step_table(steps), crossover_table(steps, cubic)]
    parts += [training_table(rows)] if rows else []
    parts.append("![Microseconds a step; points](benchmark_cubature.png)\n")
    common.tell(options.output, "benchmark_cubature", "\n".join(parts), draw(steps, cubic))
    check(steps, quick=quick)
    return 0


def find(rows: list[Row], **wanted: Any) -> list[Row]:
    """Rows with these values."""
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def check(steps: list[Row], *, quick: bool) -> None:
    """What is asserted."""
    for row in steps:
        assert row["finite"], row
        assert row["held_out"] <= 2.0 * row["tolerance"], row
    sizes = sorted({row["r"] for row in steps})
    for r in sizes:
        rough, fine = (find(steps, r=r, bodies=1, tolerance=t)[0] for t in TOLERANCES)
        assert fine["points"] > rough["points"], (rough, fine)
    fine = [find(steps, r=r, bodies=1, tolerance=TOLERANCES[1])[0]["points"] for r in sizes]
    assert fine == sorted(fine), fine
    if quick:
        return
    for row in find(steps, bodies=1):
        rest = row["step"] - row["force and tangent"] - row["solve"]
        assert rest < 30e-6 + 0.3 * row["step"], row
    for row in find(steps, bodies=512):
        single = find(steps, r=row["r"], tolerance=row["tolerance"], bodies=1)[0]
        assert row["step"] / 512.0 < single["step"], (row, single)


def introduction(cells: Sequence[int]) -> str:
    """Where and how it was measured."""
    return (
        "# Cubature: a step, its training, and the crossover with cubic\n\n"
        f"Processor time, one thread, {platform.machine()}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}. Neo-Hookean beam of {6 * int(np.prod(cells)):,} tetrahedra, "
        "poses at equilibria with strains up to 0.2. Made by `workflows/benchmark_cubature.py`.\n"
    )


def verdict(value: float, goal: float | None) -> str:
    """How a value compares with the largest allowed one."""
    return "" if goal is None else f"{goal:,.4g}: {'met' if value <= goal else 'missed'}"


def step_table(rows: list[Row]) -> str:
    """A line for each model and batch."""
    columns = ["r", "error asked", "held out", "points", "bodies", "floor", "force"]
    columns += ["force and tangent", "solve", "step", "step / floor", "us a body", "goal"]
    lines = []
    for row in rows:
        step = 1e6 * row["step"]
        goal = GOALS.get((row["r"], row["bodies"], row["tolerance"]))
        lines.append(
            [
                str(row["r"]),
                f"{row['tolerance']:.0%}",
                f"{row['held_out']:.2%}",
                str(row["points"]),
                str(row["bodies"]),
                *(
                    f"{1e6 * row[name]:,.1f}"
                    for name in ("floor", "force", "force and tangent", "solve")
                ),
                f"**{step:,.1f}**",
                f"{row['step'] / row['floor']:.2f}",
                f"{step / row['bodies']:,.1f}",
                verdict(step, goal),
            ]
        )
    return "## Implicit Newmark, one iteration a step [us]\n\n" + common.table(columns, lines)


def crossover_table(steps: list[Row], cubic: list[Row]) -> str:
    """Cubic against cubature, one body."""
    columns = ["r", "cubic [us a step]", *(f"cubature, {t:.0%} [us]" for t in TOLERANCES)]
    lines = []
    for row in cubic:
        own = [find(steps, r=row["r"], bodies=1, tolerance=t)[0] for t in TOLERANCES]
        times = [row["step"], *(one["step"] for one in own)]
        lines.append([str(row["r"]), *(f"{1e6 * value:,.1f}" for value in times)])
    told = [f"{t:.0%}: {crossing(steps, cubic, t)}" for t in TOLERANCES]
    return (
        "## Cubic or cubature: time of a step\n\n"
        + common.table(columns, lines)
        + f"\nCubature becomes the cheaper one at an r of {'; '.join(told)}.\n"
    )


def crossing(steps: list[Row], cubic: list[Row], tolerance: float) -> str:
    """Number of coordinates at which the logarithms of the times cross."""
    sizes = np.array([row["r"] for row in cubic], float)
    own = [find(steps, r=row["r"], bodies=1, tolerance=tolerance)[0]["step"] for row in cubic]
    gap = np.log([row["step"] for row in cubic]) - np.log(own)
    above = np.flatnonzero(gap > 0.0)
    if not len(above):
        return f"more than {sizes[-1]:.0f}"
    if above[0] == 0:
        return f"less than {sizes[0]:.0f}"
    place = above[0]
    share = gap[place - 1] / (gap[place - 1] - gap[place])
    return (
        f"{np.exp(np.log(sizes[place - 1]) + share * np.log(sizes[place] / sizes[place - 1])):.0f}"
    )


def training_table(rows: list[Row]) -> str:
    """What training takes."""
    columns = [
        "tetrahedra",
        "r",
        "poses",
        "points",
        "held out",
        "s",
        "candidates, poses, selection",
    ]
    lines = [
        [
            f"{row['tets']:,}",
            str(row["r"]),
            str(row["poses"]),
            str(row["points"]),
            f"{row['held_out']:.2%}",
            f"**{row['seconds']:.1f}**",
            ", ".join(f"{value:.1f}" for value in row["phases"].values()),
            verdict(row["seconds"], row["goal"]),
        ]
        for row in rows
    ]
    return "## Training to 1 %, linear tetrahedra\n\n" + common.table([*columns, "goal [s]"], lines)


def draw(steps: list[Row], cubic: list[Row]) -> Any:
    """Time of a step against r for both forces, and points against r."""
    figure, (left, right) = common.new_figure(1, 2, (11.0, 4.2))
    sizes = [row["r"] for row in cubic]
    left.loglog(sizes, [1e6 * row["step"] for row in cubic], "ko-", label="cubic, exact for StVK")
    for color, tolerance in zip(("C0", "C1"), TOLERANCES, strict=True):
        rows = find(steps, bodies=1, tolerance=tolerance)
        points = [row["points"] for row in rows]
        for name, style in (("step", "o-"), ("floor", ":")):
            values = [1e6 * row[name] for row in rows]
            label = f"cubature {tolerance:.0%}" + (", floor" if name == "floor" else "")
            left.loglog(sizes, values, color + style, label=label)
        right.plot(sizes, points, color + "o-", label=f"{tolerance:.0%} held out")
    left.set(xlabel="coordinates r", ylabel="us a step, one body")
    right.set(xlabel="coordinates r", ylabel="points")
    for axes in (left, right):
        axes.grid(which="both", alpha=0.3)
        axes.legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
