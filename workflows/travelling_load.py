"""A bridge of about 36,000 dofs over 2,000 steps, while a train of axles crosses it.

    python workflows/travelling_load.py [--output DIR] [--quick]

The bridge is that of ``meshes/bridge.py``, of a reinforced plastic; four axles of 100 kN, each of
two wheels 1.8 m apart, cross its 24 m at 72 m/s, two periods of the crown's strongest mode apart;
then the bridge swings out. The solid is of St. Venant-Kirchhoff's law and the motion that of the
full nonlinear simulator: implicit Newmark, one Newton iteration a step, Rayleigh damping of 2 % at
10 Hz and at 40 Hz, conjugate gradients.

What is asserted, of the deflection w of the crown of an arch:

- reciprocity: w under the axle at a place, found by Newton's method, is the work that the axle does
  on the field which a force at the crown causes: the static line of influence (Maxwell and Betti);
- slowness: under an axle that crawls over the bridge within a minute, w(t) is that line;
- dynamics: w(t) of the fast train is that of modal superposition, each mode integrated exactly and
  what the modes leave out added as its static part; so is the dynamic amplification, the largest
  deflection over the largest static one, which the resonance raises.
"""

import sys
import time
from dataclasses import dataclass
from typing import Any

import common
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from fenics_defo import analysis, energy, fem
from fenics_defo.analysis.point_location import locate_point
from fenics_defo.runtime import Modes
from meshes.bridge import DECK_LENGTH, DECK_TOP, RIB_AT, RISE, bridge

type Array = NDArray[np.float64]

PLASTIC = energy.StVenantKirchhoff(young=2e9, poisson=0.35, density=1000.0)
AXLE = 1e5  # [N]
WHEELS_AT = (-0.9, 0.9)  # across the bridge [m]
PERIODS_APART = 2
SPEED = 72.0  # [m/s]
SLOW_CROSSING = 60.0  # [s]
CROWN = (0.0, RIB_AT, RISE)
DAMPING_RATIO, DAMPED_AT = 0.02, (10.0, 40.0)  # [-], [Hz]


@dataclass(frozen=True, slots=True)
class Size:
    """How much is computed.

    Args:
        mesh: target edge length [m].
        places: along the deck, between the nearest two of which an axle's force is shared.
        steps: of the train's crossing and of what follows.
        duration: of both [s].
        slow_steps: of the slow crossing.
        modes: number of modes.
        axles: of the train.
    """

    mesh: float
    places: int
    steps: int
    duration: float
    slow_steps: int
    modes: int
    axles: int


FULL = Size(mesh=0.22, places=97, steps=2000, duration=1.1, slow_steps=48, modes=40, axles=4)
QUICK = Size(mesh=1.2, places=25, steps=150, duration=0.6, slow_steps=12, modes=12, axles=2)


@dataclass(frozen=True, slots=True)
class Crossing:
    """Axles that go along the deck, as point loads that come and go one after the other.

    Args:
        x: places along the deck at which forces act, its ends included [m].
        speed: [m/s].
        axles: their number.
        apart: distance between two [m], at least twice that of two places.
    """

    x: Array
    speed: float
    axles: int = 1
    apart: float = 0.0

    @property
    def starts(self) -> Array:
        """Times at which the axles come upon the deck (axles,) [s]."""
        return np.arange(self.axles) * (self.apart / self.speed)

    def loads(self) -> list[analysis.PointLoad]:
        """What acts where and when; at the ends of the deck, which are held, nothing bends it."""
        reached = (self.x - self.x[0]) / self.speed
        factors = (0.0, 1.0, 0.0) * self.axles
        return [
            wheel
            for i in range(1, len(self.x) - 1)
            for wheel in axle(
                self.x[i],
                analysis.Table((self.starts[:, None] + reached[i - 1 : i + 2]).ravel(), factors),
            )
        ]

    def weights(self, times: Array) -> Array:
        """How many axles each place carries (times, places) [-]."""
        at = self.x[0] + (times[:, None] - self.starts) * self.speed
        away = np.abs(at[:, :, None] - self.x) / (self.x[1] - self.x[0])
        parts = np.maximum(1.0 - away, 0.0).sum(axis=1)
        parts[:, [0, -1]] = 0.0
        return parts


def axle(x: float, history: Any = None) -> list[analysis.PointLoad]:
    """The two wheels of an axle at one place."""
    force = (0.0, 0.0, -AXLE / len(WHEELS_AT))
    history = history or analysis.Step()
    return [
        analysis.PointLoad(point=(x, y, DECK_TOP), vector=force, history=history) for y in WHEELS_AT
    ]


def main(argv: list[str] | None = None) -> int:
    """Simulate, compare, print and draw."""
    options = common.parser(__doc__, "travelling_load").parse_args(argv)
    size = QUICK if options.quick else FULL
    solid = fem.Solid(common.drawn(bridge, size=size.mesh), PLASTIC, fixed=["abutments"])
    x = np.linspace(-0.5 * DECK_LENGTH, 0.5 * DECK_LENGTH, size.places)
    line = influence_line(solid, x)
    results = {
        "reciprocity": reciprocity(solid, x, line),
        **slow(solid, x, line, size),
        **fast(solid, x, line, size),
    }
    text, figure = report(results, solid, size), draw(results, x, line)
    common.tell(options.output, "travelling_load", text, figure)
    check(results, quick=options.quick)
    return 0


def vertical_at(solid: fem.Solid, point: tuple[float, float, float], fields: Array) -> Array:
    """Vertical component (...) at a point of fields (..., n, 3)."""
    place = locate_point(solid, np.asarray(point), what="a probe")
    return np.asarray(fields)[..., place.rows, 2] @ place.weights


def along_deck(solid: fem.Solid, x: Array, fields: Array) -> Array:
    """Work of the axle at each place on fields (..., n, 3): (..., places) [N] times theirs."""
    wheel = -AXLE / len(WHEELS_AT)
    columns = [
        sum(wheel * vertical_at(solid, (a, y, DECK_TOP), fields) for y in WHEELS_AT)
        for a in x[1:-1]
    ]
    work = np.zeros((*np.shape(fields)[:-2], len(x)))
    work[..., 1:-1] = np.stack(columns, axis=-1)
    return work


def influence_line(solid: fem.Solid, x: Array) -> Array:
    """Static deflection of the crown for the axle at each place (places,) [m]."""
    force = 1e3  # [N]: small, for its field is to be that of the linear bridge
    unit = analysis.PointLoad(point=CROWN, vector=(0.0, 0.0, force))
    field = analysis.static_equilibrium(solid, [unit]).displacement
    return along_deck(solid, x, field) / force


def reciprocity(solid: fem.Solid, x: Array, line: Array) -> float:
    """Largest relative difference of Newton's equilibria from the line of influence."""
    worst = 0.0
    for place in (len(x) // 4, len(x) // 2):
        found = analysis.static_equilibrium(solid, axle(x[place])).displacement
        ratio = float(vertical_at(solid, CROWN, found)) / line[place]
        worst = max(worst, abs(ratio - 1.0))
    return worst


def slow(solid: fem.Solid, x: Array, line: Array, size: Size) -> dict[str, Any]:
    """One axle's crossing within a minute, and its largest distance from the line of influence."""
    crossing = Crossing(x, DECK_LENGTH / SLOW_CROSSING)
    motion = analysis.simulate(
        solid,
        crossing.loads(),
        analysis.BackwardEuler(),
        step=SLOW_CROSSING / size.slow_steps,
        duration=SLOW_CROSSING,
        probes={"crown": CROWN},
        energies_every=0,
    )
    static = crossing.weights(motion.times) @ line
    w = motion.probes["crown"][:, 2]
    error = float(np.abs(w - static).max() / np.abs(static).max())
    return {"slow error": error, "slow x": motion.times * crossing.speed, "slow": w}


def rayleigh() -> tuple[float, float]:
    """(alpha [1/s], beta [s]) of one damping ratio at two frequencies."""
    one, two = (2.0 * np.pi * f for f in DAMPED_AT)
    return 2.0 * DAMPING_RATIO * one * two / (one + two), 2.0 * DAMPING_RATIO / (one + two)


def fast(solid: fem.Solid, x: Array, line: Array, size: Size) -> dict[str, Any]:
    """The train's crossing by the simulator and by modal superposition."""
    modes = analysis.linear_modes(solid, size.modes)
    work = along_deck(solid, x, modes.shapes)
    parts = vertical_at(solid, CROWN, modes.shapes) * work.sum(axis=1) / modes.frequencies**2
    strongest = modes.frequencies[np.abs(parts).argmax()]
    crossing = Crossing(x, SPEED, size.axles, PERIODS_APART * SPEED / strongest)
    begin = time.perf_counter()
    motion = analysis.simulate(
        solid,
        crossing.loads(),
        analysis.ImplicitNewmark(),
        step=size.duration / size.steps,
        duration=size.duration,
        damping=rayleigh(),
        linear="pcg-jacobi",
        probes={"crown": CROWN},
        energies_every=0,
    )
    weights = crossing.weights(motion.times)
    static = weights @ line
    return {
        "seconds": time.perf_counter() - begin,
        "iterations": float(np.mean([step.linear_iterations for step in motion.reports])),
        "times": motion.times,
        "fast": motion.probes["crown"][:, 2],
        "modal": superposition(solid, modes, weights @ work.T, static, motion.times),
        "static": static,
        "strongest": strongest,
        "apart": crossing.apart,
        "frequencies": modes.frequencies,
    }


def superposition(
    solid: fem.Solid, modes: Modes, forces: Array, static: Array, times: Array
) -> Array:
    """Deflection of the crown (times,) [m] by modes and a static rest.

    q'' + (alpha + beta omega²) q' + omega² q = f(t) of each mode, exactly for f linear between two
    times; w = sum of phi q + (w_static - sum of phi f / omega²).

    Args:
        solid: the bridge.
        modes: k of them.
        forces: of the modes (times, k).
        static: deflection if the loads were slow (times,) [m].
        times: [s].
    """
    alpha, beta = rayleigh()
    omega, step = 2.0 * np.pi * modes.frequencies, times[1] - times[0]
    rates = np.zeros((len(omega), 4, 4))  # of (q, q', f, f')
    rates[:, 0, 1] = rates[:, 1, 2] = rates[:, 2, 3] = 1.0
    rates[:, 1, 0], rates[:, 1, 1] = -(omega**2), -(alpha + beta * omega**2)
    flow = expm(step * rates)[:, :2]
    slopes = np.diff(forces, axis=0) / step
    motion = np.zeros((len(times), len(omega), 2))
    for i, slope in enumerate(slopes):
        start = np.concatenate([motion[i], forces[i][:, None], slope[:, None]], axis=1)
        motion[i + 1] = np.einsum("kij,kj->ki", flow, start)
    return static + (motion[:, :, 0] - forces / omega**2) @ vertical_at(solid, CROWN, modes.shapes)


def amplification(results: dict[str, Any], which: str) -> float:
    """Largest deflection of the crown over the largest static one."""
    return float(np.abs(results[which]).max() / np.abs(results["static"]).max())


def difference(results: dict[str, Any]) -> float:
    """Largest difference of the train's two solutions, relative to their largest value."""
    modal = results["modal"]
    return float(np.abs(results["fast"] - modal).max() / np.abs(modal).max())


def check(results: dict[str, Any], *, quick: bool) -> None:
    """What is asserted."""
    assert results["reciprocity"] < 2e-3, results["reciprocity"]
    assert results["slow error"] < 1e-2, results["slow error"]
    assert difference(results) < (0.05 if quick else 0.02), difference(results)
    ratio = amplification(results, "fast") / amplification(results, "modal")
    assert abs(ratio - 1.0) < (0.02 if quick else 0.01), ratio
    assert amplification(results, "fast") > 1.05, amplification(results, "fast")


def report(results: dict[str, Any], solid: fem.Solid, size: Size) -> str:
    """The table as Markdown."""
    steps = len(results["times"]) - 1
    milliseconds, frequencies = 1e3 * results["seconds"] / steps, results["frequencies"]
    static = 1e3 * np.abs(results["static"]).max()
    rows = {
        "dofs": f"{solid.dof_count:,}",
        "steps of the train's crossing": f"{steps:,}",
        "ms a step": f"{milliseconds:.0f}",
        "iterations of conjugate gradients a step": f"{results['iterations']:.0f}",
        f"first of {size.modes} modes [Hz]": f"{frequencies[0]:.2f}",
        "last of them [Hz]": f"{frequencies[-1]:.2f}",
        "the crown's strongest mode [Hz]": f"{results['strongest']:.2f}",
        "distance of the axles [m]": f"{results['apart']:.3f}",
        "largest static deflection of the crown [mm]": f"{static:.4f}",
        "statics against reciprocity": f"{results['reciprocity']:.1e}",
        "slow axle against the line of influence": f"{results['slow error']:.1e}",
        "train against modes": f"{difference(results):.1e}",
        "dynamic amplification, simulated": f"{amplification(results, 'fast'):.4f}",
        "dynamic amplification, by modes": f"{amplification(results, 'modal'):.4f}",
    }
    return (
        "# A train crosses a bridge\n\n"
        + common.table(("what", "figure"), list(rows.items()))
        + "\nDifferences are relative to the largest deflection. Made by "
        + "`workflows/travelling_load.py`.\n\n"
        + "![Deflection of the crown](travelling_load.png)\n"
    )


def draw(results: dict[str, Any], x: Array, line: Array) -> Any:
    """Deflection under the slow axle against its place, and under the train against time."""
    figure, (left, right) = common.new_figure(1, 2, (10.0, 3.8))
    left.plot(x - x[0], 1e3 * line, "k-", label="line of influence")
    left.plot(results["slow x"], 1e3 * results["slow"], "o", ms=3, label="slow axle")
    left.set(xlabel="place of the axle [m]", ylabel="deflection of the crown [mm]")
    right.plot(results["times"], 1e3 * results["static"], "k:", label="static")
    right.plot(results["times"], 1e3 * results["modal"], "-", lw=3, alpha=0.4, label="modes")
    right.plot(results["times"], 1e3 * results["fast"], "-", lw=1, label="simulated")
    right.set(xlabel="time [s]")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    return figure


if __name__ == "__main__":
    sys.exit(main())
