"""The time step, from a hundredth of the explicit limit to ten thousand times it."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial

from fenics_defo import fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import FEW, MODELS, Array, box, material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, Method, free_motion
from workflows.stability_map.outcomes import Measured
from workflows.stability_map.references import Spectrum, fine_motion, oscillator, spectrum

TITLE = "Time step"
RATIOS = (0.01, 0.1, 0.5, 0.99, 1.01, 10.0, 100.0, 1e3, 1e4)
_QUICK_RATIOS = (0.5, 0.99, 1.01, 1e4)
# The sideways amplitude of the free end [m], of a column 2 m high.
_AMPLITUDE = 0.2
# How long, in limits of the explicit step, the fine reference goes on: more than a period.
_REFERENCE = 45.0


def cases(*, quick: bool) -> list[Case]:
    """All cells."""
    models = FEW[::2] if quick else tuple(MODELS)
    ratios = _QUICK_RATIOS if quick else RATIOS
    rows: dict[str, Method] = dict(METHODS)
    if quick:
        for name in ("Newmark, converged", "Newmark γ 0.6, converged", "symplectic Euler"):
            del rows[name]
    found = [
        Case(
            sweep=f"{TITLE}: {name}",
            row=model,
            column=f"{ratio:g}",
            compute=partial(cell, model, name, ratio),
        )
        for name in rows
        for model in models
        for ratio in ratios
    ]
    beyond = "central differences, unstable allowed"
    found += [
        Case(
            sweep=f"{TITLE}: {beyond}",
            row=model,
            column=f"{ratio:g}",
            compute=partial(unstable_cell, model, ratio),
        )
        for model in models
        for ratio in (1.2, 10.0, 1e4)
    ]
    return found


@lru_cache(maxsize=1)
def column(model: str) -> fem.Solid:
    """A clamped column of two cubes of 1 m."""
    return fem.Solid(box((1, 1, 2), (1.0, 1.0, 2.0)), material(model), fixed=["z<1e-6"])


@lru_cache(maxsize=2)
def vibrations(model: str, lumped: bool) -> Spectrum:
    """Of that column."""
    return spectrum(column(model), lumped=lumped)


@lru_cache(maxsize=2)
def _reference(model: str, lumped: bool) -> Callable[[Array], Array]:
    until = _REFERENCE * limit(model)
    return fine_motion(column(model), _push(model, lumped), until, lumped=lumped)


def _push(model: str, lumped: bool) -> Array:
    """The velocity (n, 3) [m/s] of the first mode at rest, in the amplitude."""
    modes = vibrations(model, lumped)
    return _AMPLITUDE * modes.omega[0] * modes.shapes[0]


def limit(model: str) -> float:
    """Largest stable step [s] of leapfrog at rest, 2 / ω of the lumped body, by LAPACK."""
    return 2.0 / vibrations(model, True).omega[-1]


def steps(ratio: float) -> int:
    """How many steps a cell does: forty, and more of the smallest."""
    return {0.01: 100, 0.1: 60}.get(ratio, 40)


def cell(model: str, name: str, ratio: float) -> Measured:
    """The column's first bending, with a step of a part or a multiple of the explicit limit."""
    method = METHODS[name]
    lumped = method.integrator.explicit
    step, count = ratio * limit(model), steps(ratio)
    velocity = _push(model, lumped)
    path = free_motion(column(model), method, step=step, count=count, velocity=velocity)
    theory = _theory(model, method, path.displacement, step) if model == "linear" else 0.0
    note = f"energy changes by {path.drift:.1e}"
    if ratio > 1.0:
        note += f", largest residual of a step {path.residual:.1e}"
    # The linear body's motion is known for all times, the others' for a period; steps beyond
    # tell no phase: what can be asked of them is only that the energy stays.
    known = path.times <= (np.inf if model == "linear" else _REFERENCE * limit(model))
    error = 1.0
    if known.sum() > 1:
        exact = _exact(model, lumped, path.times[known])
        error = float(np.abs(path.displacement[known] - exact).max()) / _AMPLITUDE
    growth = max(path.growth, float(np.abs(path.displacement).max()) / (5.0 * _AMPLITUDE))
    return Measured(error=error, theory=theory, growth=growth, note=note)


def _exact(model: str, lumped: bool, times: Array) -> Array:
    if model != "linear":
        return _reference(model, lumped)(times)
    modes = vibrations(model, lumped)
    return _AMPLITUDE * np.sin(modes.omega[0] * times)[:, None, None] * modes.shapes[0]


def _theory(model: str, method: Method, displacement: Array, step: float) -> float:
    """Distance from the method's own discrete solution of this mode."""
    modes = vibrations(model, method.integrator.explicit)
    path = oscillator(method.integrator, modes.omega[0], step, len(displacement) - 1)
    exact = _AMPLITUDE * path[:, None, None] * modes.shapes[0]
    return float(np.abs(displacement - exact).max()) / _AMPLITUDE


def unstable_cell(model: str, ratio: float) -> Measured:
    """Central differences beyond the limit, by the user's will: must end with a message."""
    method = replace(METHODS["central differences"], allow_unstable=True)
    velocity = _push(model, True)
    path = free_motion(
        column(model), method, step=ratio * limit(model), count=3000, velocity=velocity
    )
    return Measured(error=1.0, growth=path.growth)
