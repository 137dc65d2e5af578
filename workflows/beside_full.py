"""A reduced run beside the full one: the same body, the same loads, the same steps."""

import statistics
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import common
import numpy as np
from numpy.typing import NDArray

from fenics_defo import analysis, fem, reduction, runtime

type Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Story:
    """A body's motion under named loads.

    Args:
        solid: body.
        loads: by name; their histories are followed by both runs.
        step: of both [s].
        steps: number of them.
        damping: Rayleigh's (alpha [1/s], beta [s]).
        watched: point [m] whose displacement is drawn.
        linear: solver of the full simulation's equations.
        tolerance: of conjugate gradients.
        newton: iterations a step of both; None until converged.
    """

    solid: fem.Solid
    loads: Mapping[str, Any]
    step: float
    steps: int
    damping: tuple[float, float]
    watched: tuple[float, float, float]
    linear: str = "cholesky"
    tolerance: float = 1e-6
    newton: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Full:
    """The full simulation.

    Args:
        times: (k,) [s].
        frames: displacements (k, n, 3) [m].
        watched: displacement (k, 3) [m] of the point.
        step_seconds: median of a step [s].
    """

    times: Array
    frames: Array
    watched: Array
    step_seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """One reduced model's run beside the full one.

    Args:
        name: what it is called in the table.
        model: it.
        offline: seconds to make it.
        frames_error: ‖u − u_full‖_M over the largest ‖u_full‖_M (k,) [-].
        watched: displacement (k, 3) [m] of the point.
        step_seconds: median of a step [s].
        q: coordinates (k, r).
    """

    name: str
    model: runtime.ReducedModel
    offline: float
    frames_error: Array
    watched: Array
    step_seconds: float
    q: Array

    @property
    def largest_error(self) -> float:
        """Over the whole motion [-]."""
        return float(self.frames_error.max())


def run_full(story: Story, every: int) -> Full:
    """The full run; ``every`` so many steps a frame is kept."""
    simulation = analysis.Simulation(
        story.solid,
        list(story.loads.values()),
        analysis.ImplicitNewmark(),
        step=story.step,
        damping=story.damping,
        newton=story.newton,
        linear=story.linear,
        linear_tolerance=story.tolerance,
        probes={"watched": story.watched},
    )
    frames, watched, times, seconds = [], [], [], []
    for number in range(1, story.steps + 1):
        begin = time.perf_counter()
        simulation.advance()
        seconds.append(time.perf_counter() - begin)
        if number % every == 0:
            frames.append(simulation.state.displacement)
            watched.append(simulation.probe("watched"))
            times.append(simulation.time)
    return Full(np.array(times), np.array(frames), np.array(watched), statistics.median(seconds))


def model_of(
    story: Story, basis: reduction.Basis, force: str, **options: Any
) -> tuple[runtime.ReducedModel, float]:
    """The model that carries the story's loads and its watched point, and the seconds it took."""
    begin = time.perf_counter()
    model = reduction.reduce(
        story.solid,
        basis,
        force,
        loads=story.loads,
        probes={"watched": story.watched},
        damping=story.damping,
        range_tolerance=None,
        **options,
    )
    return model, time.perf_counter() - begin


def run_reduced(
    story: Story, name: str, model: runtime.ReducedModel, offline: float, full: Full, every: int
) -> Reduced:
    """The reduced run with the same integrator, step and loads."""
    iterations = {"newton": story.newton} if story.newton else {"newton": 3}
    run = runtime.ImplicitNewmark(model, step=story.step, **iterations)
    rows = {name: model.load(name) for name in story.loads}
    q, seconds = [], []
    for number in range(1, story.steps + 1):
        now = number * story.step
        load = sum(story.loads[key].history(now) * row for key, row in rows.items())
        begin = time.perf_counter()
        run.advance(load)
        seconds.append(time.perf_counter() - begin)
        if number % every == 0:
            q.append(run.q.copy())
    path = np.array(q)
    mass = story.solid.lumped_mass()
    whole = _norms(full.frames, mass).max()
    apart = [
        _norms(model.displacement(at)[None] - frame, mass)[0]
        for at, frame in zip(path, full.frames, strict=True)
    ]
    return Reduced(
        name=name,
        model=model,
        offline=offline,
        frames_error=np.array(apart) / whole,
        watched=np.array([model.probe("watched", at) for at in path]),
        step_seconds=statistics.median(seconds),
        q=path,
    )


def report(story: Story, full: Full, runs: list[Reduced], remark: str) -> str:
    """A table of all runs and a remark, as Markdown."""
    rows = [
        (
            f"full, {story.solid.dof_count:,} dofs",
            "–",
            f"{1e3 * full.step_seconds:.1f} ms",
            "–",
            "–",
            "–",
        )
    ]
    for run in runs:
        rows.append(
            (
                run.name,
                f"{run.offline:.1f} s",
                f"{1e6 * run.step_seconds:.0f} µs",
                f"{full.step_seconds / run.step_seconds:,.0f}",
                f"{100 * run.largest_error:.2f} %",
                f"{100 * float(np.sqrt((run.frames_error**2).mean())):.2f} %",
            )
        )
    columns = ("run", "offline", "a step", "times faster", "largest error", "rms error")
    newton = f"{story.newton} Newton iteration" if story.newton else "Newton's method converged"
    solver = (
        "MUMPS" if story.linear == "cholesky" else f"conjugate gradients to {story.tolerance:g}"
    )
    head = (
        f"{story.steps:,} steps of implicit Newmark of {1e3 * story.step:g} ms, {newton}, the full "
        f"run with {solver}; one thread. Errors are of the displacement of the whole body, in the "
        "norm of the mass, relative to the largest one of the motion.\n\n"
    )
    return head + common.table(columns, rows) + "\n" + remark + "\n"


def draw(full: Full, runs: list[Reduced], axis: int, what: str) -> Any:
    """The watched point's path and the error over time."""
    figure, (above, below) = common.new_figure(2, 1, (8.0, 6.5))
    above.plot(full.times, 1e3 * full.watched[:, axis], "k", label="full")
    for run in runs:
        above.plot(full.times, 1e3 * run.watched[:, axis], "--", label=run.name)
        below.semilogy(full.times, np.maximum(run.frames_error, 1e-8), label=run.name)
    above.set_ylabel(f"{what} [mm]")
    above.legend(fontsize=8)
    below.set_ylabel("error of the displacement [-]")
    below.set_xlabel("time [s]")
    below.grid(alpha=0.3)
    return figure


def _norms(frames: Array, mass: Array) -> Array:
    """√(uᵀ M u) with the lumped mass, of frames (k, n, 3)."""
    norms: Array = np.sqrt(np.einsum("kni,n,kni->k", frames, mass, frames))
    return norms
