"""Dynamics for ``validation.py``: one mode, orders, energy and momentum, a swinging bar."""

import itertools
from pathlib import Path

import numpy as np
import test_free_motion as free
import test_motion_converges as swing
import test_turek_hron as bar
from motions import EXPLICIT, INTEGRATORS, ORDERS, modal_motion, one_mode
from motions import bar as small_bar
from validation_figures import drawn
from validation_report import Chapter, Check

from fenics_defo.beams import DampedOscillator, rayleigh_oscillator
from fenics_defo.energy import StVenantKirchhoff

type Array = np.ndarray


def oscillator(name: str) -> tuple[DampedOscillator, tuple[float, float]]:
    """Theory of the second mode at a fortieth of critical damping, and Rayleigh's coefficients."""
    omega = one_mode(small_bar(), 1, lumped=name in EXPLICIT).omega
    damping = (0.025 * omega, 0.025 / omega)
    theory = rayleigh_oscillator(
        frequency=omega / (2.0 * np.pi), mass_damping=damping[0], stiffness_damping=damping[1]
    )
    return theory, damping


def period_and_decay(times: Array, q: Array) -> tuple[float, float]:
    """From the places of the zeros and the sizes at equal phases, by linear interpolation."""
    sign = np.flatnonzero(np.signbit(q[1:]) != np.signbit(q[:-1]))
    zeros = times[sign] - q[sign] * (times[sign + 1] - times[sign]) / (q[sign + 1] - q[sign])
    period = 2.0 * float(np.diff(zeros).mean())
    late = np.interp(times[0] + 2.0 * period, times, q)
    return period, float(np.log(q[0] / late) / (2.0 * period))


def damped_mode(figures: Path) -> Chapter:
    """Period and decay of one mode, against the oscillator's."""
    checks = []
    with drawn(figures / "one_mode.png", size=(7.0, 3.6)) as axes:
        for name in INTEGRATORS:
            theory, damping = oscillator(name)
            per_period = 200 if name in EXPLICIT else 30
            for count, check in ((per_period, False), (1200, True)):
                step = theory.period / count
                _, q, _ = modal_motion(
                    INTEGRATORS[name],
                    number=1,
                    step=step,
                    count=round(2.2 * count),
                    damping=damping,
                )
                times = step * np.arange(len(q))
                if check:
                    # From the first full period on: its phase there is that of the start.
                    period, decay = period_and_decay(times, q)
                    bounds = {"newmark": (1e-4, 1e-3), "backward-euler": (2e-3, 0.15)}
                    bound, decay_bound = bounds.get(name, (1e-3, 0.05))
                    checks += [
                        Check(f"{name}: period [s]", period, theory.period, bound),
                        Check(f"{name}: decay [1/s]", decay, theory.decay_rate, decay_bound),
                    ]
                else:
                    axes.plot(times / theory.period, q, ".-", label=f"{name}, {count} a period")
        theory, _ = oscillator("newmark")
        t = np.linspace(0.0, 2.2, 400)
        axes.plot(t, theory.free_motion(t * theory.period, start=1.0), "k-", linewidth=1)
        axes.set(xlabel="time / period", ylabel="modal coordinate")
    text = """
The second mode of a thick bar alone, with Rayleigh damping of both kinds, a fortieth of critical.
Black: theory. The table: 1200 steps a period; backward Euler's own damping still is a tenth there
of the body's.

![one mode](validation/one_mode.png)
"""
    return Chapter("Period and decay of one mode", text, tuple(checks))


def orders(figures: Path) -> Chapter:
    """Observed order of each integrator on a nonlinear motion."""
    checks = []
    with drawn(figures / "orders.png") as axes:
        for name in INTEGRATORS:
            counts = (80, 160, 320, 640, 1280) if name in EXPLICIT else (20, 40, 80, 160, 320)
            found = [swing.swung(name, count, None) for count in counts]
            steps = swing.TIME / np.array(counts[:-1])
            gaps = [np.linalg.norm(a - b) for a, b in itertools.pairwise(found)]
            axes.loglog(steps, gaps, "o-", label=name)
            observed = float(np.log2(gaps[-2] / gaps[-1]))
            checks.append(Check(f"{name}: observed order", observed, ORDERS[name], 0.1))
        for name in ("newmark", "backward-euler"):
            found = [swing.swung(name, count, 1) for count in (80, 160, 320)]
            gaps = [np.linalg.norm(a - b) for a, b in itertools.pairwise(found)]
            observed = float(np.log2(gaps[0] / gaps[1]))
            what = f"{name}, one Newton iteration a step: observed order"
            checks.append(Check(what, observed, ORDERS[name], 0.1))
        axes.set(xlabel="step [s]", ylabel="change of the tip on halving the step [m]")
    text = """
The weight of a St. Venant-Kirchhoff bar comes on smoothly: place and velocity of its tip after a
given time, when it hangs by a seventh of its length.

![orders](validation/orders.png)
"""
    return Chapter("Order of convergence in time", text, tuple(checks))


def energy(figures: Path) -> Chapter:
    """Energy and momenta of a tumbling body."""
    checks = []
    with drawn(figures / "energy.png", size=(7.0, 3.6)) as axes:
        for name in INTEGRATORS:
            motion = free.tumble(name, step=0.004, duration=6.0)
            total = motion.energies.kinetic + motion.energies.strain
            strain = motion.energies.strain[0]
            change = (total - total[0]) / strain
            axes.plot(motion.times, change, label=name)
            if name != "backward-euler":
                half = len(change) // 2
                drift = float(change[half:].mean() - change[1 : half + 1].mean())
                checks.append(
                    Check(
                        f"{name}: mean energy, second half less first, over strain",
                        drift,
                        0.0,
                        0.01,
                    )
                )
            linear, angular = free.losses(small_bar(StVenantKirchhoff, fixed=()), name)
            checks.append(Check(f"{name}: relative change of momentum", linear, 0.0, 1e-9))
            bound = {"newmark": 0.01, "backward-euler": 0.05}.get(name, 1e-10)
            checks.append(
                Check(f"{name}: relative change of angular momentum", angular, 0.0, bound)
            )
        axes.set(xlabel="time [s]", ylabel="change of energy / strain energy", ylim=(-1.1, 0.4))
    text = """
A free St. Venant-Kirchhoff bar, strained by five per cent and thrown with spin; no damping. The
explicit methods keep momentum and angular momentum to round-off, the implicit ones momentum only;
the energy of all but backward Euler is bounded without drift.

![energy](validation/energy.png)
"""
    return Chapter("Free flight: energy and momentum", text, tuple(checks))


def swinging_bar(figures: Path) -> Chapter:
    """Turek and Hron's CSM3."""
    times, x, y = bar.swing(cells=17, layers=1, step=0.02, duration=10.0)
    late = times > 8.0
    with drawn(figures / "swinging_bar.png", size=(7.0, 3.6)) as axes:
        axes.plot(times, y, label="uy of A")
        axes.plot(times, x, label="ux of A")
        for mean, amplitude in (bar.CSM3_Y, bar.CSM3_X):
            axes.axhspan(mean - amplitude, mean + amplitude, alpha=0.1)
        axes.set(xlabel="time [s]", ylabel="displacement [mm]")
    checks = []
    for name, values, (mean, amplitude) in (("x", x, bar.CSM3_X), ("y", y, bar.CSM3_Y)):
        middle = 0.5 * (values[late].max() + values[late].min())
        half = 0.5 * np.ptp(values[late])
        checks += [
            Check(f"CSM3: mean of u{name} [mm]", float(middle), mean, 0.02),
            Check(f"CSM3: amplitude of u{name} [mm]", float(half), amplitude, 0.02),
        ]
    checks.append(
        Check("CSM3: frequency [Hz]", bar.frequency(times[late], y[late]), bar.CSM3_HERTZ, 0.01)
    )
    text = """
The same bar released from its straight shape (CSM3): 17 x 1 second-order hexahedra, average
acceleration with the step 0.02 s, Newton's iteration converged. As in the proposal, mean and
amplitude are those of the extreme values late in the motion, here from 8 to 10 s; bands: as
published.

![swinging bar](validation/swinging_bar.png)
"""
    return Chapter("A swinging bar: Turek and Hron's CSM3", text, tuple(checks))


CASES = {
    "one-mode": damped_mode,
    "orders": orders,
    "energy": energy,
    "swinging-bar": swinging_bar,
}
