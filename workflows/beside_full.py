"""A reduced run beside the full one: the same body, the same loads, the same steps."""

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import common
import numpy as np
from numpy.typing import NDArray

from fenics_defo import analysis, fem, reduction, runtime

type Array = NDArray[np.float64]
type Force = Callable[[int, runtime.ImplicitNewmark], Array]  # of the step's number, and the run


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
        every: so many steps a frame is kept.
    """

    solid: fem.Solid
    loads: Mapping[str, Any]
    step: float
    steps: int
    damping: tuple[float, float]
    watched: tuple[float, float, float]
    linear: str = "cholesky"
    tolerance: float = 1e-6
    newton: int | None = 1
    every: int = 4

    @property
    def frames(self) -> int:
        """Number of them."""
        return self.steps // self.every


@dataclass(frozen=True, slots=True, eq=False)
class Full:
    """The full simulation.

    Args:
        times: (k,) [s].
        frames: displacements (k, n, 3) [m].
        watched: displacement (k, 3) [m] of the point.
        step_seconds: processor's time of a step, the median over the frames [s].
    """

    times: Array
    frames: Array
    watched: Array
    step_seconds: float

    @property
    def farthest(self) -> float:
        """Largest displacement of the watched point [m]."""
        return float(np.linalg.norm(self.watched, axis=1).max())


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """One reduced model's run beside the full one.

    Args:
        name: what it is called in the table.
        model: it.
        offline: seconds to make it.
        frames_error: ‖u − u_full‖_M over the largest ‖u_full‖_M (k,) [-].
        watched: displacement (k, 3) [m] of the point.
        step_seconds: processor's time of a step, the median over the frames [s].
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
    def mean_error(self) -> float:
        """Root mean square over the motion [-]."""
        return float(np.sqrt((self.frames_error**2).mean()))

    @property
    def largest_error(self) -> float:
        """Over the whole motion [-]."""
        return float(self.frames_error.max())


def run_full(story: Story, initial: analysis.Initial | None = None) -> Full:
    """The full run, from rest if nothing else is said."""
    simulation = analysis.Simulation(
        story.solid,
        list(story.loads.values()),
        analysis.ImplicitNewmark(),
        step=story.step,
        damping=story.damping,
        newton=story.newton,
        linear=story.linear,
        linear_tolerance=story.tolerance,
        initial=initial,
        probes={"watched": story.watched},
    )
    frames, watched, times, seconds = [], [], [], []
    with simulation:
        for _ in range(story.frames):
            begin = time.process_time()
            for _ in range(story.every):
                simulation.advance()
            seconds.append((time.process_time() - begin) / story.every)
            frames.append(simulation.state.displacement)
            watched.append(simulation.probe("watched"))
            times.append(simulation.time)
    return Full(np.array(times), np.array(frames), np.array(watched), statistics.median(seconds))


def model_of(
    story: Story, basis: reduction.Basis, force: str, **options: Any
) -> tuple[runtime.ReducedModel, float]:
    """The model that carries the story's loads and its watched point, and the seconds it took."""
    begin = time.process_time()
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
    return model, time.process_time() - begin


def run_reduced(
    story: Story,
    name: str,
    model: runtime.ReducedModel,
    offline: float,
    full: Full,
    force: Force | None = None,
) -> Reduced:
    """The reduced run with the same integrator and steps.

    Args:
        story: told.
        name: for the table.
        model: of the story's body.
        offline: seconds to make it.
        full: the run beside it.
        force: generalised force (r,) at the end of a step; that of the story's loads if not given.
    """
    run = runtime.ImplicitNewmark(model, step=story.step, newton=story.newton)
    forces = forces_over_time(story, model)
    path, seconds = np.zeros((story.frames, model.size)), []
    for frame in range(story.frames):
        begin = time.process_time()
        for number in range(frame * story.every, (frame + 1) * story.every):
            run.advance(forces[number] if force is None else force(number, run))
        seconds.append((time.process_time() - begin) / story.every)
        path[frame] = run.q
    return Reduced(
        name=name,
        model=model,
        offline=offline,
        frames_error=errors(story.solid, model, path, full.frames),
        watched=model.probe("watched", path),
        step_seconds=statistics.median(seconds),
        q=path,
    )


def linearisation(story: Story, run: Reduced) -> float:
    """Largest change of a reduced motion when Newton's method converges in each step [-].

    In the norm of the mass, over the largest displacement: what few iterations a step cost.
    """
    forces = forces_over_time(story, run.model)
    other = runtime.ImplicitNewmark(run.model, step=story.step, newton=None)
    path = []
    for number, force in enumerate(forces, start=1):
        other.advance(force)
        if number % story.every == 0:
            path.append(other.q.copy())
    apart, whole = np.array(path) - run.q, run.q
    size = [np.einsum("ki,ij,kj->k", q, run.model.mass, q).max() for q in (apart, whole)]
    return float(np.sqrt(size[0] / size[1]))


def forces_over_time(story: Story, model: runtime.ReducedModel) -> Array:
    """Generalised forces at the ends of the steps (steps, r)."""
    times = story.step * np.arange(1, story.steps + 1)
    forces = np.zeros((story.steps, model.size))
    for name, load in story.loads.items():
        forces += np.outer([load.history(now) for now in times], model.load(name))
    return forces


def errors(solid: fem.Solid, model: runtime.ReducedModel, path: Array, frames: Array) -> Array:
    """Errors (k,) of the whole body's displacement at coordinates (k, r), see `Reduced`."""
    mass = solid.lumped_mass()
    whole = max(_norm(frame, mass) for frame in frames)
    apart = [
        _norm(model.displacement(q) - frame, mass) for q, frame in zip(path, frames, strict=True)
    ]
    return np.array(apart) / whole


def setting(story: Story) -> str:
    """How both were run, in a sentence or two."""
    newton = {1: "one Newton iteration", None: "Newton's method converged"}.get(
        story.newton, f"{story.newton} Newton iterations"
    )
    solver = (
        "Cholesky factors"
        if story.linear == "cholesky"
        else f"conjugate gradients to {story.tolerance:.0e}"
    )
    return (
        f"{story.steps:,} steps of implicit Newmark of {1e3 * story.step:.3g} ms, {newton} a step, "
        f"in both; the full run's linear systems by {solver}. Times are the processor's, of one "
        "thread, in one run of the script. Errors are of the displacement of the whole body in "
        "the norm of the mass, relative to the largest one of the motion.\n"
    )


def run_table(story: Story, full: Full, runs: list[Reduced]) -> str:
    """A table of all runs, as Markdown."""
    name, step = f"full, {story.solid.dof_count:,} dofs", f"{1e3 * full.step_seconds:.1f} ms"
    rows = [(name, "", step, "", "", "")]
    for run in runs:
        rows.append(
            (
                run.name,
                f"{run.offline:.1f} s",
                f"{1e6 * run.step_seconds:.0f} µs",
                f"{full.step_seconds / run.step_seconds:,.0f}",
                f"{100 * run.largest_error:.2f} %",
                f"{100 * run.mean_error:.2f} %",
            )
        )
    columns = ("run", "offline", "a step", "times faster", "largest error", "rms error")
    return common.table(columns, rows)


def draw(full: Full, runs: list[Reduced], axis: int, what: str) -> Any:
    """The watched point's path and the error over time."""
    figure, (above, below) = common.new_figure(2, 1, (8.0, 6.5))
    draw_paths(above, full, runs, axis)
    draw_errors(below, full, runs)
    above.set_ylabel(f"{what} [mm]")
    below.set_xlabel("time [s]")
    one_legend(figure, above)
    return figure


def one_legend(figure: Any, axes: Any, columns: int = 2) -> None:
    """One legend above a figure, of what these axes show."""
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=columns, fontsize=8)


def draw_paths(
    axes: Any, full: Full, runs: list[Reduced], axis: int, names: Sequence[str] = ()
) -> None:
    """A component of the watched point's displacement over time; ``names`` instead of the runs'."""
    axes.plot(full.times, 1e3 * full.watched[:, axis], "k", lw=3, alpha=0.35, label="full")
    for run, name in zip(runs, names or [run.name for run in runs], strict=True):
        axes.plot(full.times, 1e3 * run.watched[:, axis], lw=1.2, label=name)
    axes.grid(alpha=0.3)


def draw_errors(axes: Any, full: Full, runs: list[Reduced]) -> None:
    """Errors over time."""
    for run in runs:
        axes.semilogy(full.times, np.maximum(run.frames_error, 1e-8), lw=1.2, label=run.name)
    axes.set_ylabel("error of the displacement [-]")
    axes.grid(alpha=0.3)


def _norm(field: Array, mass: Array) -> float:
    """√(uᵀ M u) of a field (n, 3) with the lumped mass."""
    return float(np.sqrt(np.einsum("ni,n,ni->", field, mass, field)))
