"""Microseconds of a runtime step and where they go, beside what no step can go below.

    python workflows/benchmark_runtime.py [--output DIR] [--quick] [--runtime-only]

Models of r coordinates with all coefficients of a cubic force are stepped by implicit Newmark, one
Newton iteration a step, alone and in batches. The floor is one product with the tabulated
coefficients: a vector's for one body, a matrix's for a batch. A step adds to it the rest of force
and tangent, the linear solve, and what the integrator itself takes. Beside the other integrators
stands the exact filter of 100 linear modes at 44.1 kHz; then what is done once and for all: the
tabulation of cubic coefficients and modal derivatives.

All times are those of this process's processor time with one thread, the least of several rounds
in which the things compared take turns: other programs disturb them less than a clock on the wall,
though those that empty the caches still do.

What is asserted: all motions stay finite; a body in a batch moves as alone; the integrator itself
costs no more than some calls of NumPy; batches are cheaper a body than single steps of small
models; runs of the filter are several times cheaper than single steps; tabulation grows as the
number of tetrahedra and no faster than the fourth power of r, with memory that hardly grows. The
goals are told as met or missed, with the floor beside them.
"""

import platform
import sys
from typing import Any

import common
import numpy as np
import timings
from benchmark_dynamics import processor
from timings import Row

from fenics_defo.runtime import integrators

SIZES, BATCHES = (10, 15, 20, 30, 50, 60, 100), (1, 64, 512)
#: Goals [us] of a Newmark step by (r, bodies).
GOALS = {
    (10, 1): 12.0,
    (15, 1): 22.0,
    (30, 1): 45.0,
    (50, 1): 240.0,
    (60, 1): 1000.0,
    (35, 512): 30_000.0,
}
#: Vega's C++ with OpenBLAS, one thread [us].
VEGA = {10: 2.2, 15: 5.3, 20: 11.0, 30: 48.0, 50: 880.0}
AUDIO_GOAL = 20.0  # times real time
#: (bricks, r, goal [s]) of tabulations; six tetrahedra a brick.
TABULATIONS = (
    ((48, 8, 8), 20, 0.6),
    ((60, 12, 12), 30, 5.0),
    ((24, 8, 8), 20, None),
    ((96, 8, 8), 20, None),
    ((48, 8, 8), 10, None),
    ((48, 8, 8), 40, None),
)
DERIVATIVES = ((48, 14, 14), 20, 5.0)  # 33,075 degrees of freedom


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark."""
    parser = common.parser(__doc__, "benchmark_runtime")
    parser.add_argument("--runtime-only", action="store_true", help="no tabulation or derivatives")
    options = parser.parse_args(argv)
    quick = options.quick
    seconds = 0.002 if quick else 0.05
    cases = [(r, b) for r in SIZES for b in BATCHES] + [(35, 512)]
    if quick:
        cases = [(r, b) for r in (5, 10) for b in (1, 8)]
    models = {r: timings.cubic_model(r) for r in dict.fromkeys(r for r, _ in cases)}
    steps = [timings.step_row(models[r], b, seconds=seconds) for r, b in cases]
    methods = [timings.method_row(model, seconds=seconds) for model in models.values()]
    modes, count = (10, 2000) if quick else (100, timings.AUDIO_RATE)
    filters = [
        timings.filter_row(modes, count, hold, seconds=seconds) for hold in ("constant", "linear")
    ]
    tables, derivatives = ([], []) if options.runtime_only else offline(quick=quick)
    parts = [introduction(), step_table(steps), methods_table(methods), filter_table(filters)]
    parts += [offline_table(tables, derivatives)] if tables else []
    parts.append("![Microseconds a step](benchmark_runtime.png)\n")
    common.tell(options.output, "benchmark_runtime", "\n".join(parts), draw(steps))
    check(steps, filters, tables, quick=quick)
    return 0


def offline(*, quick: bool) -> tuple[list[Row], list[Row]]:
    """Tabulations, and modal derivatives."""
    if quick:
        rows = [timings.tabulation_row((n, 2, 2), 4, rounds=1) for n in (8, 16)]
        return rows, [timings.derivative_row((8, 2, 2), 3)]
    rows = []
    for cells, r, goal in TABULATIONS:
        rows.append({**timings.tabulation_row(cells, r, rounds=2), "goal": goal})
    cells, count, goal = DERIVATIVES
    return rows, [{**timings.derivative_row(cells, count), "goal": goal}]


def find(rows: list[Row], **wanted: Any) -> list[Row]:
    """Rows with these values."""
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def check(steps: list[Row], filters: list[Row], tables: list[Row], *, quick: bool) -> None:
    """What is asserted."""
    assert all(row["finite"] for row in steps)
    check_batches()
    for row in filters:
        assert 2.0 * row["run"] < row["advance"], row
    if quick:
        return
    for row in steps:
        # Some ten calls of NumPy, and for batches passes over all tangents.
        allowed = 20e-6 + 0.5 * (row["force and tangent"] + row["solve"])
        assert row["rest"] < allowed, row
    for r in (10, 15, 20):
        single, batch = (find(steps, r=r, bodies=bodies)[0] for bodies in (1, 512))
        assert batch["step"] / 512.0 < single["step"], batch
    if tables:
        tets, coordinates = growth(tables)
        assert tets < 1.3, tables
        assert coordinates < 4.5, tables
        small, large = (find(tables, tets=6 * n * 64, r=20)[0]["megabytes"] for n in (24, 96))
        assert large < 1.5 * small, tables


def growth(tables: list[Row]) -> tuple[float, float]:
    """Exponents of the time of tabulation by tetrahedra, and by coordinates between 10 and 40."""
    by_tets = find(tables, r=20)
    by_r = find(tables, tets=6 * 48 * 64)
    return (
        common.exponent([row["tets"] for row in by_tets], [row["seconds"] for row in by_tets]),
        common.exponent([row["r"] for row in by_r], [row["seconds"] for row in by_r]),
    )


def check_batches() -> None:
    """Each body of a batch moves as it does alone."""
    model = timings.cubic_model(10)
    loads = timings.loads_of(model, 3)
    batch = integrators.ImplicitNewmark(model, step=timings.STEP, batch=3)
    alone = [integrators.ImplicitNewmark(model, step=timings.STEP) for _ in loads]
    for _ in range(200):
        batch.advance(loads)
        for motion, load in zip(alone, loads, strict=True):
            motion.advance(load)
    np.testing.assert_allclose(batch.q, [motion.q for motion in alone], rtol=1e-9)


def introduction() -> str:
    """Where and how it was measured."""
    return (
        "# A runtime step: microseconds and where they go\n\n"
        f"Processor time, one thread, {processor()}, Python {platform.python_version()}, NumPy "
        f"{np.__version__}. Made by `workflows/benchmark_runtime.py`.\n"
    )


def verdict(value: float, goal: float | None) -> str:
    """How a value compares with the largest allowed one."""
    return "" if goal is None else f"{goal:,.4g}: {'met' if value <= goal else 'missed'}"


def step_table(rows: list[Row]) -> str:
    """A line for each model and batch."""
    columns = ["r", "bodies", "table [MB]", "floor", "force and tangent", "solve", "rest", "step"]
    columns += ["step / floor", "us a body", "steps/s of all", "goal", "Vega's C++"]
    lines = []
    for row in rows:
        step = 1e6 * row["step"]
        names = ("floor", "force and tangent", "solve", "rest")
        lines.append(
            [
                str(row["r"]),
                str(row["bodies"]),
                f"{row['megabytes']:.2f}",
                *(f"{1e6 * row[name]:,.1f}" for name in names),
                f"**{step:,.1f}**",
                f"{row['step'] / row['floor']:.2f}",
                f"{step / row['bodies']:,.1f}",
                f"{1.0 / row['step']:,.0f}",
                verdict(step, GOALS.get((row["r"], row["bodies"]))),
                f"{VEGA[row['r']]:g}" if row["bodies"] == 1 and row["r"] in VEGA else "",
            ]
        )
    return (
        "## Implicit Newmark with a cubic force, one iteration a step [us]\n\n"
        "`floor` is one product with the coefficients; `rest` is the integrator's own. Where a "
        "step misses its goal, compare its floor: no arrangement of calls goes below that.\n\n"
        + common.table(columns, lines)
    )


def methods_table(rows: list[Row]) -> str:
    """A line for each model."""
    names = [name for name in rows[0] if name != "r"]
    lines = [[str(row["r"]), *(f"{1e6 * row[name]:,.1f}" for name in names)] for row in rows]
    return "## Integrators, one body [us a step]\n\n" + common.table(["r", *names], lines)


def filter_table(rows: list[Row]) -> str:
    """A line for each way a load goes on between steps."""
    names = ("run", "runs of 64", "advance")
    columns = ["modes", "load between steps"]
    columns += [part for name in names for part in (f"{name} [us a step]", "times real time")]
    lines = [
        [
            str(row["modes"]),
            row["hold"],
            *(
                text
                for name in names
                for text in (
                    f"{1e6 * row[name]:.2f}",
                    f"{1.0 / (timings.AUDIO_RATE * row[name]):.1f}",
                )
            ),
            verdict(timings.AUDIO_RATE * row["run"], 1.0 / AUDIO_GOAL),
        ]
        for row in rows
    ]
    return (
        "## The exact filter of linear modes at 44.1 kHz, a load on each mode\n\n"
        f"The goal is {AUDIO_GOAL:g} times real time, {1.0 / AUDIO_GOAL:g} s for a second.\n\n"
        + common.table([*columns, "goal [s]"], lines)
    )


def offline_table(tables: list[Row], derivatives: list[Row]) -> str:
    """What is done once and for all."""
    lines = [
        [
            f"{row['tets']:,}",
            str(row["r"]),
            f"{row['seconds']:.2f}",
            verdict(row["seconds"], row.get("goal")),
            f"{row['megabytes']:.0f}",
        ]
        for row in tables
    ]
    text = "## Tabulation of cubic coefficients, linear tetrahedra\n\n" + common.table(
        ["tetrahedra", "r", "s", "goal [s]", "peak of memory [MB]"], lines
    )
    if len(tables) > 2:
        tets, r = growth(tables)
        text += f"\nSeconds grow as tetrahedra^{tets:.2f} and r^{r:.2f}.\n"
    lines = [
        [
            f"{row['dofs']:,}",
            str(row["derivatives"]),
            f"{row['seconds']:.2f}",
            verdict(row["seconds"], row.get("goal")),
            ", ".join(f"{name} {value:.2f}" for name, value in row["phases"].items()),
        ]
        for row in derivatives
    ]
    return (
        text
        + "\n## Modal derivatives\n\n"
        + common.table(["dofs", "derivatives", "s", "goal [s]", "phases [s]"], lines)
    )


def draw(rows: list[Row]) -> Any:
    """A step of one body against r with its parts, and the time a body against the batch."""
    figure, (left, right) = common.new_figure(1, 2, (11.0, 4.2))
    single = find(rows, bodies=1)
    sizes = [row["r"] for row in single]
    for name, style in (("floor", "k:"), ("force and tangent", "C0--"), ("step", "C0o-")):
        left.loglog(sizes, [1e6 * row[name] for row in single], style, label=name)
    goals = {r: goal for (r, bodies), goal in GOALS.items() if bodies == 1 and r in sizes}
    left.loglog(list(goals), list(goals.values()), "C1x", label="goal")
    vega = {r: value for r, value in VEGA.items() if r in sizes}
    left.loglog(list(vega), list(vega.values()), "C2+", label="Vega's C++")
    left.set(xlabel="coordinates r", ylabel="us a step, one body")
    left.grid(which="both", alpha=0.3)
    left.legend()
    for r in sizes:
        series = find(rows, r=r)
        bodies = [row["bodies"] for row in series]
        values = [1e6 * row["step"] / row["bodies"] for row in series]
        right.loglog(bodies, values, "o-", label=f"r = {r}")
    right.set(xlabel="bodies in a batch", ylabel="us a step and body")
    right.grid(which="both", alpha=0.3)
    right.legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
