"""512 baskets of r = 35 in one batch of the runtime, each pushed and set in motion its own way.

    python workflows/baskets.py [--output DIR] [--quick]

The baskets of ``meshes/basket.py``, of a soft plastic, stand fast on their bottoms; the rim of each
is pulled to a side and down by a force of its own direction and size, and each starts with a
velocity of its own along some vibration modes. All are steps of one batch: one product of the
tabulated cubic coefficients with a matrix of all bodies' coordinates, and a linear system a body.
The course (Barbič, SIGGRAPH 2012, part 2) reports 1.2 s a step for 512 baskets that fall into a
heap, with the contact between them; here nothing touches, so that the figures compare the
deformation's part only.

What is asserted: bodies of the batch move as they do in single runs, to round-off; one of them as
the full simulation of it does, within some per cent; the rims move by a centimetre, and each
its own way; a body in the batch costs less than a step of it alone.
"""

import statistics
import sys
import time
from dataclasses import dataclass, replace
from typing import Any

import beside_full
import common
import numpy as np
from numpy.typing import NDArray

from fenics_defo import analysis, energy, fem, reduction, runtime
from meshes.basket import HEIGHT, RIM_RADIUS, basket

type Array = NDArray[np.float64]

PLASTIC = energy.StVenantKirchhoff(young=2e6, poisson=0.35, density=950.0)
PULL = 1000.0  # on the rim, sideways [Pa]
SPEED = 0.6  # of the fastest node at the start [m/s]
MOVED = 6  # modes that the initial velocities are made of
COURSE = 1.2  # [s] a step, with contact
AMPLITUDE = 0.01  # of the first mode, at which derivatives are weighed against modes [m]
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, -1.0)}


@dataclass(frozen=True, slots=True)
class Size:
    """How much is computed.

    Args:
        mesh: target edge length [m].
        bodies: of the batch.
        modes: k of them.
        r: columns of the basis.
        steps: of 5 ms.
        alone: number of bodies that are run alone too.
    """

    mesh: float
    bodies: int
    modes: int
    r: int
    steps: int
    alone: int


FULL = Size(0.008, 512, 12, 35, 200, 4)
QUICK = Size(0.016, 32, 6, 24, 24, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """What moves each body.

    Args:
        pulls: parts of the loads "x", "y" and "z" (b, 3) [-].
        velocities: at time zero (b, r).
    """

    pulls: Array
    velocities: Array


def drawn_motions(model: runtime.ReducedModel, bodies: int) -> Motions:
    """Pulls around the rim, and velocities along the model's lowest modes, at random."""
    random = np.random.default_rng(2012)
    angle, size = 2.0 * np.pi * random.random(bodies), 0.3 + 0.7 * random.random(bodies)
    down = 0.5 * random.random(bodies)
    pulls = size[:, None] * np.stack([np.cos(angle), np.sin(angle), down], axis=1)
    _, modes = np.linalg.eigh(model.stiffness(np.zeros(model.size)))
    velocities = random.standard_normal((bodies, MOVED)) @ modes[:, :MOVED].T
    fastest = np.linalg.norm(model.displacement(velocities), axis=-1).max(axis=1)
    return Motions(pulls, velocities * (SPEED * random.random(bodies) / fastest)[:, None])


def story(size: Size) -> beside_full.Story:
    """The basket and the loads that the pulls are made of."""
    solid = fem.Solid(common.drawn(basket, size=size.mesh), PLASTIC, fixed=["bottom"])
    release = analysis.Table((0.0, 0.1, 0.4, 0.42), (0.0, 1.0, 1.0, 0.0))
    loads = {
        name: analysis.Traction("rim", tuple(PULL * np.array(axis)), history=release)
        for name, axis in AXES.items()
    }
    rim = np.array((RIM_RADIUS, 0.0, HEIGHT))
    return beside_full.Story(
        solid=solid,
        loads=loads,
        step=5e-3,
        steps=size.steps,
        damping=(0.5, 1e-4),
        watched=tuple(solid.points[int(np.argmin(np.linalg.norm(solid.points - rim, axis=1)))]),
        linear="cholesky",
        every=2,
    )


def basis_of(solid: fem.Solid, size: Size) -> reduction.Basis:
    """Static answers to pulls to some sides, with modes and their derivatives."""
    modes = analysis.linear_modes(solid, size.modes, verify=False)
    farthest = float(np.linalg.norm(modes.shapes[0], axis=1).max())
    sides = [(np.cos(a), np.sin(a), 0.0) for a in 2.0 * np.pi / 3.0 * np.arange(3)] + [AXES["z"]]
    pulls = [[analysis.Traction("rim", tuple(PULL * np.array(side)))] for side in sides]
    pulled = [analysis.static_equilibrium(solid, pull).displacement for pull in pulls]
    static = reduction.snapshot_basis(solid, np.array(pulled), size=len(sides))
    curved = reduction.modal_derivative_basis(
        solid, modes, size=size.r - len(sides), amplitude=AMPLITUDE / farthest
    )
    return reduction.join(solid, static, curved)


@dataclass(frozen=True, slots=True, eq=False)
class Flock:
    """The batch's run.

    Args:
        paths: coordinates (frames, b, r).
        step_seconds: processor's time of a step of all bodies, the median [s].
    """

    paths: Array
    step_seconds: float


def run_flock(
    told: beside_full.Story, model: runtime.ReducedModel, motions: Motions, bodies: Any
) -> Flock:
    """Some bodies in one batch; one body alone for a single number."""
    forces = motions.pulls[bodies] @ np.array([model.load(name) for name in AXES])
    run = runtime.ImplicitNewmark(model, step=told.step, v=motions.velocities[bodies])
    history = next(iter(told.loads.values())).history
    paths, seconds = [], []
    for frame in range(told.frames):
        begin = time.process_time()
        for number in range(frame * told.every, (frame + 1) * told.every):
            run.advance(history(told.step * (number + 1)) * forces)
        seconds.append((time.process_time() - begin) / told.every)
        paths.append(run.q.copy())
    return Flock(np.array(paths), statistics.median(seconds))


def one_told(told: beside_full.Story, motions: Motions, body: int) -> beside_full.Story:
    """The story of one body of the batch."""
    loads = {
        name: replace(load, vector=tuple(part * np.array(load.vector)))
        for part, (name, load) in zip(motions.pulls[body], told.loads.items(), strict=True)
    }
    return replace(told, loads=loads)


def main(argv: list[str] | None = None) -> int:
    """Run all, print, draw and check."""
    options = common.parser(__doc__, "baskets").parse_args(argv)
    size = QUICK if options.quick else FULL
    told = story(size)
    begin = time.process_time()
    model, _ = beside_full.model_of(told, basis_of(told.solid, size), "cubic")
    offline = time.process_time() - begin
    motions = drawn_motions(model, size.bodies)
    flock = run_flock(told, model, motions, np.arange(size.bodies))
    alone = [run_flock(told, model, motions, body) for body in range(size.alone)]
    velocity = model.displacement(motions.velocities[0])
    full = beside_full.run_full(one_told(told, motions, 0), analysis.Initial(velocity=velocity))
    error = beside_full.errors(told.solid, model, flock.paths[:, 0], full.frames)
    results = {
        "offline": offline,
        "batch": flock.step_seconds,
        "alone": statistics.median(run.step_seconds for run in alone),
        "full": full.step_seconds,
        "apart": max(
            float(np.abs(flock.paths[:, body] - run.paths).max() / np.abs(run.paths).max())
            for body, run in enumerate(alone)
        ),
        "error": error,
        "farthest": largest(model, flock.paths),
        "rim": model.probe("watched", flock.paths),
        "full rim": full,
    }
    common.tell(options.output, "baskets", report(told, results, size), draw(results))
    check(results, quick=options.quick)
    return 0


def largest(model: runtime.ReducedModel, paths: Array) -> Array:
    """Largest displacement (b,) of each body's watched point [m]."""
    norms: Array = np.linalg.norm(model.probe("watched", paths), axis=-1).max(axis=0)
    return norms


def report(told: beside_full.Story, results: dict[str, Any], size: Size) -> str:
    """The table as Markdown."""
    batch, alone, full = (results[name] for name in ("batch", "alone", "full"))
    moved = 1e3 * results["farthest"]
    rows = {
        "bodies, coordinates of each": f"{size.bodies}, {size.r}",
        "dofs of a body": f"{told.solid.dof_count:,}",
        "offline: modes, derivatives, statics, tabulation": f"{results['offline']:.1f} s",
        "a step of the batch": f"{1e3 * batch:.2f} ms",
        "of it, a body": f"{1e6 * batch / size.bodies:.0f} µs",
        "a step of a body alone": f"{1e6 * alone:.0f} µs",
        "a full step of one body": f"{1e3 * full:.0f} ms",
        "the batch is faster than as many full simulations": f"{full * size.bodies / batch:,.0f}",
        "a step of the course's 512 baskets, with contact": f"{COURSE:.1f} s",
        "batch against single runs": f"{results['apart']:.1e}",
        "a body against the full one, largest error": f"{100 * results['error'].max():.2f} %",
        "largest displacement at the rim": f"{moved.min():.0f} mm to {moved.max():.0f} mm",
    }
    return (
        f"# {size.bodies} baskets\n\n"
        + beside_full.setting(told)
        + "Nothing touches anything here; the course's time contains the contact, and its machine "
        + "was another.\n\n"
        + common.table(("what", "figure"), list(rows.items()))
        + "\nMade by `workflows/baskets.py`.\n\n![Rims of the baskets](baskets.png)\n"
    )


def draw(results: dict[str, Any]) -> Any:
    """The rims of all bodies over time, and the error of the one that was simulated fully."""
    figure, (above, below) = common.new_figure(2, 1, (8.0, 6.5))
    full, rims = results["full rim"], 1e3 * results["rim"][:, :, 0]
    above.plot(full.times, rims[:, 1:], color="C0", lw=0.4, alpha=0.2)
    above.plot(full.times, 1e3 * full.watched[:, 0], "k", lw=3, zorder=3, label="one, full")
    above.plot(full.times, rims[:, 0], "C1", lw=1.2, zorder=4, label="the same in the batch")
    above.set_ylabel("a point of the rim along x [mm]")
    above.legend(fontsize=8)
    below.semilogy(full.times, results["error"], "C1")
    below.set(xlabel="time [s]", ylabel="error of the displacement [-]")
    for each in (above, below):
        each.grid(alpha=0.3)
    return figure


def check(results: dict[str, Any], *, quick: bool) -> None:
    """What is asserted."""
    assert results["apart"] < 1e-9, results["apart"]
    assert results["error"].max() < 0.12, results["error"].max()
    assert results["farthest"].max() > 7e-3, results["farthest"]
    assert np.ptp(results["rim"][-1], axis=0).min() > 1e-3, "all move alike"
    if not quick:
        assert results["batch"] < COURSE, results["batch"]
        assert results["batch"] / results["rim"].shape[1] < results["alone"], results["batch"]


if __name__ == "__main__":
    sys.exit(main())
