"""Times of runtime models and of what makes them, in seconds of this process's processor time."""

import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import common
import numpy as np

from fenics_defo import analysis, energy, fem, reduction
from fenics_defo.runtime import CubicForce, LinearForce, ReducedModel, integrators
from fenics_defo.runtime.integrators.dense_solver import solve

type Row = dict[str, Any]
type Work = Callable[[], object]

AUDIO_RATE = 44100
STEP = 1e-3


def alternate(works: Mapping[str, Work], *, seconds: float, rounds: int = 7) -> dict[str, float]:
    """Seconds of one call of each, the least of some rounds in which they take turns.

    Args:
        works: functions by name.
        seconds: how long one function is called in one round, about; once at least.
        rounds: number of them, fewer for functions that take longer than ``seconds``.
    """
    calls, best = {}, {}
    for name, work in works.items():
        work()
        once = _timed(work, 1)
        calls[name] = max(1, int(seconds / max(once, 1e-7)))
        best[name] = once
    slowest = max(best.values())
    for _ in range(rounds if slowest < seconds else min(rounds, 3)):
        for name, work in works.items():
            best[name] = min(best[name], _timed(work, calls[name]))
    return best


def _timed(work: Work, calls: int) -> float:
    begin = time.process_time()
    for _ in range(calls):
        work()
    return (time.process_time() - begin) / calls


def cubic_model(r: int) -> ReducedModel:
    """A model with all coefficients of a cubic force, whose motion stays small."""
    rng = np.random.default_rng(r)
    squares = (2.0 * np.pi * np.linspace(1.0, 30.0, r)) ** 2
    counts = [r * (r + 1) * (r + 2) // 6, r * (r + 1) * (r + 2) * (r + 3) // 24]
    third, fourth = (rng.normal(size=count) for count in counts)
    law = CubicForce.from_unique(np.diag(squares), third, fourth)
    return ReducedModel(law=law, mass=np.eye(r), damping=(0.1, 1e-4))


def loads_of(model: ReducedModel, bodies: int) -> np.ndarray:
    """A load for each body; the first is that of a single one."""
    return np.random.default_rng(7).normal(size=(bodies, model.size))


def step_row(model: ReducedModel, bodies: int, *, seconds: float) -> Row:
    """Force and tangent, solve and a whole Newmark step, beside the floor."""
    r = model.size
    shape = (r,) if bodies == 1 else (bodies, r)
    load = loads_of(model, bodies).reshape(shape)
    motion = integrators.ImplicitNewmark(model, step=STEP, batch=None if bodies == 1 else bodies)
    evaluator = model.law.evaluator(shape)
    q, x = np.full(shape, 1e-3), np.empty(shape)
    matrix = np.array(evaluator.force_and_stiffness(q)[1]) + 4.0 / STEP**2 * np.eye(r)
    pairs = r * (r + 1) // 2
    table = np.ones((pairs, 1 + r + pairs))
    given = np.ones(table.shape[1] if bodies == 1 else (table.shape[1], bodies))
    product = np.empty(pairs if bodies == 1 else (pairs, bodies))
    times = alternate(
        {
            "floor": lambda: np.dot(table, given, product),
            "force and tangent": lambda: evaluator.force_and_stiffness(q),
            "solve": lambda: solve(matrix, load, x),
            "step": lambda: motion.advance(load),
        },
        seconds=seconds,
    )
    rest = times["step"] - times["force and tangent"] - times["solve"]
    first = motion.q if bodies == 1 else motion.q[0]
    return {
        "r": r,
        "bodies": bodies,
        "megabytes": table.nbytes / 1e6,
        **times,
        "rest": rest,
        "finite": bool(np.isfinite(first).all()),
    }


def method_row(model: ReducedModel, *, seconds: float) -> Row:
    """A step of each integrator with one body."""
    load = loads_of(model, 1)[0]
    plain: dict[str, Any] = {"step": STEP, "damping": (0.1, 0.0)}
    makers = {
        "Newmark": lambda: integrators.ImplicitNewmark(model, step=STEP),
        "Newmark, 2 iterations": lambda: integrators.ImplicitNewmark(model, step=STEP, newton=2),
        "backward Euler": lambda: integrators.BackwardEuler(model, step=STEP),
        "central differences": lambda: integrators.CentralDifferences(model, **plain),
        "symplectic Euler": lambda: integrators.SymplecticEuler(model, **plain),
        "Newmark with energies": lambda: integrators.ImplicitNewmark(
            model, step=STEP, energies=True
        ),
    }
    motions = {name: make() for name, make in makers.items()}
    works = {name: (lambda motion=motion: motion.advance(load)) for name, motion in motions.items()}
    return {"r": model.size, **alternate(works, seconds=seconds)}


def filter_row(modes: int, steps: int, hold: Any, *, seconds: float) -> Row:
    """The exact filter: a long run, runs of 64 steps, and one step."""
    omega = 2.0 * np.pi * np.linspace(50.0, 15000.0, modes)
    law = LinearForce(np.diag(omega**2))
    model = ReducedModel(law=law, mass=np.eye(modes), damping=(2.0, 1e-8))
    motion = integrators.ModalFilter(model, step=1.0 / AUDIO_RATE, hold=hold)
    loads = np.random.default_rng(0).normal(size=(steps, modes))
    out = np.empty_like(loads)
    times = alternate(
        {
            "run": lambda: motion.run(loads, out=out),
            "runs of 64": lambda: motion.run(loads[:64], out=out[:64]),
            "advance": lambda: motion.advance(loads[0]),
        },
        seconds=seconds,
    )
    per_step = {"run": times["run"] / steps, "runs of 64": times["runs of 64"] / 64.0}
    return {"modes": modes, "hold": hold, **per_step, "advance": times["advance"]}


def beam(cells: Sequence[int]) -> fem.Solid:
    """A clamped box beam 4 x 1 x 1 m of tetrahedra, six to a brick."""
    material = energy.StVenantKirchhoff(young=1e6, poisson=0.4, density=1000.0)
    return fem.Solid(common.box((4.0, 1.0, 1.0), cells), material, fixed=["x<1e-6"])


def tabulation_row(cells: Sequence[int], r: int, *, rounds: int) -> Row:
    """The cubic coefficients of a beam, and the memory that computing them took [MB]."""
    solid = beam(cells)
    shapes = 1e-3 * np.random.default_rng(0).normal(size=(r, len(solid.points), 3))
    reduction.tabulate_cubic(solid, shapes[:2])  # compiles, and builds what a body builds once
    best = min(_timed(lambda: reduction.tabulate_cubic(solid, shapes), 1) for _ in range(rounds))
    tracemalloc.start()
    try:
        reduction.tabulate_cubic(solid, shapes)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    return {"tets": 6 * int(np.prod(cells)), "r": r, "seconds": best, "megabytes": peak / 1e6}


def derivative_row(cells: Sequence[int], count: int) -> Row:
    """Modal derivatives of a beam by phases."""
    solid = beam(cells)
    modes = analysis.linear_modes(solid, count)
    reduction.modal_derivatives(solid, modes.select(range(2)))
    phases = analysis.Phases()
    begin = time.process_time()
    found = reduction.modal_derivatives(solid, modes, phases=phases)
    seconds = time.process_time() - begin
    return {
        "dofs": 3 * len(solid.points),
        "modes": count,
        "derivatives": len(found),
        "seconds": seconds,
        "phases": dict(phases.seconds),
    }
