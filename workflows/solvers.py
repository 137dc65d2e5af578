"""Time and iterations of a step against Young's modulus, for each linear solver.

At a fixed time step the equations of a soft body are nearly those of its mass alone, whatever its
stiffness; those of a stiff body are as ill-conditioned as its statics. Conjugate gradients feel the
difference, a direct solver does not:

    python workflows/solvers.py [--output DIR] [--quick]

The body is a clamped box beam 4 x 1 x 1 m of tetrahedra, density 1000 kg/m³, Poisson's ratio 0.45,
of St. Venant-Kirchhoff's law, which begins to sag under gravity: implicit Newmark, 0.01 s, one
Newton iteration a step, no damping, conjugate gradients to 1e-6.

What is asserted: the solvers agree on the motion; the iterations of conjugate gradients with
Jacobi's preconditioner never fall by a tenth as Young's modulus rises and grow more than tenfold
over the range; multigrid's grow less; the direct solver needs one solve a step everywhere.
"""

import statistics
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import common
import numpy as np

from fenics_defo import analysis, energy, fem

SOLVERS = ("cholesky", "pcg-jacobi", "pcg-amg")
YOUNG = (1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10)
STEP = 0.01
CELLS, STEPS = (48, 8, 8), 10  # 11,907 dofs
QUICK_CELLS, QUICK_STEPS = (12, 3, 3), 3
TIP = (4.0, 0.5, 0.5)


@dataclass(frozen=True, slots=True)
class Measured:
    """One run.

    Args:
        milliseconds: median of a step.
        iterations: mean of a step's linear solve.
        tip: displacement of the free end at the end [m].
    """

    milliseconds: float
    iterations: float
    tip: float


def main(argv: list[str] | None = None) -> int:
    """Measure, check, print and draw."""
    options = common.parser(__doc__, "solvers").parse_args(argv)
    cells, steps = (QUICK_CELLS, QUICK_STEPS) if options.quick else (CELLS, STEPS)
    data = common.box((4.0, 1.0, 1.0), cells)
    runs = {solver: [measure(data, young, solver, steps) for young in YOUNG] for solver in SOLVERS}
    check(runs, quick=options.quick)
    common.tell(options.output, "solvers", report(runs, cells, steps), draw(runs))
    return 0


def measure(data: Any, young: float, solver: Any, steps: int) -> Measured:
    """A few steps of the beam; the first, which finds the order of elimination, is not timed."""
    rubber = energy.StVenantKirchhoff(young=young, poisson=0.45, density=1000.0)
    solid = fem.Solid(data, rubber, fixed=["x<1e-6"])
    seconds, iterations = [], []
    with analysis.Simulation(
        solid,
        [analysis.Gravity()],
        analysis.ImplicitNewmark(),
        step=STEP,
        linear=solver,
        probes={"tip": TIP},
    ) as simulation:
        simulation.advance()
        for _ in range(steps):
            begin = time.perf_counter()
            report = simulation.advance()
            seconds.append(time.perf_counter() - begin)
            iterations.append(report.linear_iterations)
        tip = float(simulation.probe("tip")[2])
    return Measured(1e3 * statistics.median(seconds), statistics.mean(iterations), tip)


def check(runs: dict[str, list[Measured]], *, quick: bool) -> None:
    """What holds on any machine."""
    direct, jacobi, multigrid = (runs[solver] for solver in SOLVERS)
    for solver in SOLVERS:
        tips = np.array([run.tip for run in runs[solver]])
        np.testing.assert_allclose(tips, [run.tip for run in direct], rtol=1e-3, err_msg=solver)
    assert all(run.iterations == 1 for run in direct)
    counts = [run.iterations for run in jacobi]
    assert all(after >= 0.9 * before for before, after in pairwise(counts)), counts
    assert growth(jacobi) > (5.0 if quick else 10.0), counts
    assert growth(multigrid) < 0.5 * growth(jacobi), [run.iterations for run in multigrid]
    if not quick:  # far from the noise: it is thirty times there, and two here
        assert jacobi[-1].milliseconds > 3.0 * jacobi[0].milliseconds
        assert max(run.milliseconds for run in direct) < 2.5 * min(
            run.milliseconds for run in direct
        )


def growth(runs: list[Measured]) -> float:
    """Iterations of the stiffest body over those of the softest."""
    return runs[-1].iterations / runs[0].iterations


def report(runs: dict[str, list[Measured]], cells: tuple[int, int, int], steps: int) -> str:
    """The table as Markdown."""
    dofs = 3 * int(np.prod(np.array(cells) + 1))
    columns = ["Young's modulus [Pa]"]
    columns += [f"{solver}, ms a step (iterations)" for solver in SOLVERS]
    rows = [
        [f"{young:.0e}"]
        + [f"{runs[s][i].milliseconds:.0f} ({runs[s][i].iterations:.0f})" for s in SOLVERS]
        for i, young in enumerate(YOUNG)
    ]
    title = f"# Linear solvers against stiffness: box beam of {dofs:,} dofs\n\n"
    about = (
        f"\nMedian of {steps} steps of {STEP:g} s, one thread. From the softest body to the "
        f"stiffest the iterations grow {growth(runs['pcg-jacobi']):.0f} times with Jacobi's "
        f"preconditioner and {growth(runs['pcg-amg']):.1f} times with multigrid. Made by "
        "`workflows/solvers.py`.\n\n![Time and iterations against Young's modulus](solvers.png)\n"
    )
    return title + common.table(columns, rows) + about


def draw(runs: dict[str, list[Measured]]) -> Any:
    """Time and iterations against Young's modulus."""
    figure, (left, right) = common.new_figure(1, 2, (9.0, 3.8))
    for solver, style in zip(SOLVERS, ("ko-", "s-", "^-"), strict=True):
        left.loglog(YOUNG, [run.milliseconds for run in runs[solver]], style, label=solver)
        right.loglog(YOUNG, [run.iterations for run in runs[solver]], style, label=solver)
    left.set(xlabel="Young's modulus [Pa]", ylabel="ms a step")
    right.set(xlabel="Young's modulus [Pa]", ylabel="iterations a step")
    for axes in (left, right):
        axes.grid(which="both", alpha=0.3)
    left.legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
