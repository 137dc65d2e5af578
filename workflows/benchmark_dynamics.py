"""Milliseconds of an implicit step and where they go, for each model, solver, size and rank.

    python workflows/benchmark_dynamics.py [--output DIR] [--quick]

The body is a clamped box beam 4 x 1 x 1 m of tetrahedra, six to a brick, of 1e6 Pa and 1000 kg/m³,
which begins to sag under gravity: implicit Newmark, 0.01 s, stiffness damping 0.01 s, one Newton
iteration a step, conjugate gradients to 1e-6. Each size is measured in a process of its own, with
one rank and with two.

The floor is the linear solve alone: MUMPS's factorisation and substitution, or what prepares
conjugate gradients and their iterations. What a step adds to it is the tangent, with the force at
the same place; the residual, which are the products with mass and damping; and the rest, which is
the driver's. Beside them stands the force alone, which an explicit method needs.

What is asserted: all solvers and both numbers of ranks give the same motion; with the full sizes
also relations of times that hold on any machine: force and tangent cost less than MUMPS's
factorisation from 12,000 dofs on; those of the corotational and invertible laws less than four
times St. Venant-Kirchhoff's, but for noise; the driver's rest is a few per cent.
"""

import contextlib
import json
import platform
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import common
import numpy as np

from fenics_defo import analysis, energy, fem
from fenics_defo.fem.compat import MPI

type Row = dict[str, Any]

SOLVERS = ("cholesky", "pcg-jacobi", "pcg-amg")
PHASES = ("residual", "tangent", "factorise", "solve", "rest")
SIZES = {"3k": (20, 6, 6), "12k": (48, 8, 8), "36k": (60, 13, 13), "101k": (92, 18, 18)}
QUICK_SIZES = {"0.2k": (8, 2, 2), "0.6k": (12, 3, 3)}
#: The beam of other programs' figures, 43,875 dofs and 75,264 tetrahedra.
BEAM = {"44k": (64, 14, 14)}
BEAM_YOUNG = (1e5, 1e6, 1e7)
BEAM_MODELS, QUICK_MODELS = ("StVK", "corotational"), ("StVK", "corotational")
POISSON, DENSITY = 0.4, 1000.0
STEP, DAMPING = 0.01, (0.0, 0.01)
TIP = (4.0, 0.5, 0.5)
LEAST_STEPS, MOST_STEPS, SECONDS = 3, 12, 3.0  # timed steps of a case: at least, at most, so long
MARK = "measured: "  # before the rows that a process prints


def materials(young: float) -> dict[str, Any]:
    """The models, of equal moduli at rest but for the springs' Poisson's ratio of 1/4."""
    hooke = {"young": young, "poisson": POISSON, "density": DENSITY}
    mu = young / (2.0 * (1.0 + POISSON))
    bulk = young / (3.0 * (1.0 - 2.0 * POISSON))
    return {
        "linear": energy.LinearElastic(**hooke),
        "corotational": energy.Corotational(**hooke),
        "StVK": energy.StVenantKirchhoff(**hooke),
        "neo-Hookean": energy.NeoHookean(**hooke),
        "Mooney-Rivlin": energy.MooneyRivlin(
            c10=0.375 * mu, c01=0.125 * mu, bulk=bulk, density=DENSITY
        ),
        "invertible": energy.Invertible(energy.NeoHookean(**hooke)),
        "mass-spring": energy.MassSpring(young=young, density=DENSITY),
    }


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark, or one process of it."""
    parser = common.parser(__doc__, "benchmark_dynamics")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2], help="numbers of ranks")
    parser.add_argument("--measure", help="measure one job, as JSON; what the script itself calls")
    options = parser.parse_args(argv)
    if options.measure:
        rows = measure_all(**json.loads(options.measure))
        if MPI.COMM_WORLD.rank == 0:
            print(MARK + json.dumps(rows))
        return 0
    sizes = QUICK_SIZES if options.quick else SIZES
    models = QUICK_MODELS if options.quick else tuple(materials(1.0))
    rows = []
    for size, cells in sizes.items():
        job = {"size": size, "cells": cells, "models": models, "solvers": SOLVERS, "young": 1e6}
        for ranks in [1] if size == "0.2k" else sorted({1, *options.ranks}):
            rows += in_own_process(ranks, **job)
    beam = [] if options.quick else beam_rows()
    common.tell(
        options.output, "benchmark_dynamics", report(rows, beam), draw(rows, list(sizes)[-2])
    )
    check(rows, quick=options.quick)
    return 0


def beam_rows() -> list[Row]:
    """The beam of other programs' figures, with Jacobi's preconditioner."""
    return [
        row
        for young in BEAM_YOUNG
        for size, cells in BEAM.items()
        for row in in_own_process(
            1, size=size, cells=cells, models=BEAM_MODELS, solvers=("pcg-jacobi",), young=young
        )
    ]


def in_own_process(ranks: int, **job: Any) -> list[Row]:
    """Measure some models and solvers of one size in a fresh process, or in two."""
    command = [sys.executable, __file__, "--measure", json.dumps(job)]
    if ranks > 1:
        beside = Path(sys.executable).with_name("mpiexec")
        command = [
            str(beside) if beside.exists() else shutil.which("mpiexec") or "mpiexec",
            "-n",
            str(ranks),
            *command,
        ]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{job} on {ranks} ranks:\n{done.stdout}\n{done.stderr}")
    line = next(line for line in done.stdout.splitlines() if line.startswith(MARK))
    print(f"{job['size']}, {ranks} rank{'s' * (ranks > 1)}: measured", file=sys.stderr)
    return list(json.loads(line.removeprefix(MARK)))


def measure_all(
    size: str, cells: list[int], models: list[str], solvers: list[str], young: float
) -> list[Row]:
    """Rows of one size, for each model and solver; collective."""
    rows = []
    for model in models:
        data = common.box((4.0, 1.0, 1.0), cells)
        solid = fem.Solid(data, materials(young)[model], fixed=["x<1e-6"])
        for solver in solvers:
            row = measure(solid, solver)
            rows.append({"size": size, "model": model, "solver": solver, "young": young} | row)
    return rows


def measure(solid: fem.Solid, solver: Any) -> Row:
    """Medians of a few steps [ms]; the first, which allocates, is not counted. Collective."""
    phases = analysis.Phases()
    steps: list[dict[str, float]] = []
    iterations = []
    with analysis.Simulation(
        solid,
        [analysis.Gravity()],
        analysis.ImplicitNewmark(),
        step=STEP,
        damping=DAMPING,
        linear=solver,
        probes={"tip": TIP},
        phases=phases,
    ) as simulation:
        simulation.advance()
        tip = [float(simulation.probe("tip")[2])]
        begun = time.perf_counter()
        while len(steps) < MOST_STEPS and go_on(solid.comm, len(steps), begun):
            phases.seconds.clear()
            begin = time.perf_counter()
            report = simulation.advance()
            total = time.perf_counter() - begin
            spent = {name: phases.seconds.get(name, 0.0) for name in PHASES[:-1]}
            steps.append(spent | {"rest": total - sum(spent.values()), "total": total})
            iterations.append(report.linear_iterations)
            tip.append(float(simulation.probe("tip")[2]))
    medians = {"force alone": force_alone(solid)} | {
        name: 1e3 * statistics.median(step[name] for step in steps) for name in (*PHASES, "total")
    }
    return {
        "dofs": solid.dof_count,
        "ranks": solid.comm.size,
        "iterations": statistics.mean(iterations),
        "tip": tip[LEAST_STEPS],
    } | medians


def force_alone(solid: fem.Solid) -> float:
    """Median of an evaluation of the internal force at rest [ms]; collective."""
    rest, seconds = np.zeros((len(solid.nodes.rows), 3)), []
    for _ in range(LEAST_STEPS):
        begin = time.perf_counter()
        solid.assembly.force(rest)
        seconds.append(time.perf_counter() - begin)
    return 1e3 * statistics.median(seconds)


def go_on(comm: MPI.Comm, steps: int, begun: float) -> bool:
    """Whether to time another step; the same answer on each rank."""
    more = steps < LEAST_STEPS or time.perf_counter() - begun < SECONDS
    return bool(comm.bcast(more))


def find(rows: list[Row], **wanted: Any) -> list[Row]:
    """Rows with these values."""
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def assembly(row: Row) -> float:
    """Milliseconds of force and tangent."""
    return float(row["residual"] + row["tangent"])


def check(rows: list[Row], *, quick: bool) -> None:
    """What is asserted."""
    for row in rows:
        (same,) = find(rows, model=row["model"], size=row["size"], solver="cholesky", ranks=1)
        np.testing.assert_allclose(row["tip"], same["tip"], rtol=1e-3, err_msg=str(row))
        assert row["solver"] != "cholesky" or row["iterations"] == 1, row
    if quick:
        return
    for row in find(rows, ranks=1):
        if row["dofs"] < 10_000:
            continue
        assert row["rest"] < 0.05 * row["total"], row
        if row["solver"] == "cholesky":
            assert assembly(row) < row["factorise"], row
        if row["model"] in ("corotational", "invertible"):
            (plain,) = find(rows, ranks=1, model="StVK", size=row["size"], solver=row["solver"])
            assert assembly(row) < 5.0 * assembly(plain), row


def report(rows: list[Row], beam: list[Row]) -> str:
    """The tables as Markdown."""
    parts = [
        "# An implicit step: milliseconds and where they go\n",
        f"Medians, one thread a rank, {processor()}, Python {platform.python_version()}. "
        "`factorise` and `solve` are the floor, the linear solve alone; with conjugate gradients "
        "`factorise` is what prepares them. Made by `workflows/benchmark_dynamics.py`.\n",
        row_table(rows),
        "## Growth with the dofs: exponents, one rank\n",
        exponent_table(rows),
    ]
    if beam:
        parts += [
            "## The beam of 64 x 14 x 14 bricks, stiffness damping 0.01 s, conjugate gradients\n",
            "Stiffness decides how many iterations there are: compare at equal iterations.\n",
            row_table(beam, with_young=True),
        ]
    return "\n".join([*parts, "![Milliseconds a step](benchmark_dynamics.png)\n"])


def row_table(rows: list[Row], *, with_young: bool = False) -> str:
    """A line a row."""
    columns = ["model", "solver", "dofs", "ranks", "iterations", "force alone", *PHASES]
    columns += ["total", "total / floor", "ms an iteration"]
    lines = [
        [
            row["model"],
            row["solver"],
            f"{row['dofs']:,}",
            str(row["ranks"]),
            f"{row['iterations']:.0f}",
            *(f"{row[phase]:.1f}" for phase in ("force alone", *PHASES)),
            f"**{row['total']:.1f}**",
            f"{row['total'] / (row['factorise'] + row['solve']):.2f}",
            f"{row['solve'] / row['iterations']:.2f}",
        ]
        for row in rows
    ]
    if with_young:
        columns = ["Young's modulus [Pa]", *columns]
        lines = [[f"{row['young']:.0e}", *line] for row, line in zip(rows, lines, strict=True)]
    return common.table(columns, lines)


def exponent_table(rows: list[Row]) -> str:
    """Exponents p of milliseconds ~ dofs^p."""
    names = ("force alone", "residual", "tangent", "factorise", "solve", "total")
    lines = []
    for model in dict.fromkeys(row["model"] for row in rows):
        for solver in SOLVERS:
            series = find(rows, model=model, solver=solver, ranks=1)
            dofs = [row["dofs"] for row in series]
            values = [[max(row[name], 1e-3) for row in series] for name in names]
            lines.append([model, solver, *(f"{common.exponent(dofs, v):.2f}" for v in values)])
    return common.table(("model", "solver", *names), lines)


def processor() -> str:
    """Name of the processor, where the system tells it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.machine()


def draw(rows: list[Row], size: str) -> Any:
    """Phases by model at one size, and the step against the dofs with its floor."""
    figure, (left, right) = common.new_figure(1, 2, (11.0, 4.2))
    chosen = find(rows, size=size, solver="pcg-jacobi", ranks=1)
    models = [row["model"] for row in chosen]
    bottom = np.zeros(len(chosen))
    for phase in PHASES:
        heights = np.array([row[phase] for row in chosen])
        left.barh(models, heights, left=bottom, label=phase)
        bottom += heights
    left.invert_yaxis()
    left.set(xlabel=f"ms a step, pcg-jacobi, {chosen[0]['dofs']:,} dofs")
    left.legend()
    for solver, colour in zip(SOLVERS, ("k", "C0", "C1"), strict=True):
        series = find(rows, model="StVK", solver=solver, ranks=1)
        dofs = [row["dofs"] for row in series]
        floor = [row["factorise"] + row["solve"] for row in series]
        right.loglog(dofs, [row["total"] for row in series], "o-", color=colour, label=solver)
        right.loglog(dofs, floor, ":", color=colour)
    right.set(xlabel="degrees of freedom", ylabel="ms a step, StVK; dotted: the solve alone")
    right.grid(which="both", alpha=0.3)
    right.legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
