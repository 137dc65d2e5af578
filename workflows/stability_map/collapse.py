"""Loads up to full collapse: cells that are flattened, turned inside out, and come back."""

from functools import lru_cache, partial

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import (
    DENSITY,
    MODELS,
    POISSON,
    YOUNG,
    box,
    lame,
    material,
    principal_stress,
)
from workflows.stability_map.cases import Case
from workflows.stability_map.hearing import listen
from workflows.stability_map.outcomes import EXACT, Measured

CRUSH_TITLE = "Crushed to a stretch"
LOAD_TITLE = "Dead pressure over λ + 2 μ"
BACK_TITLE = "Recovery by backward Euler"
_STRETCHES = (0.9, 0.5, 0.2, 0.1, 0.01, 0.0, -0.1, -0.5, -1.0)
_LOADS = (0.1, 0.19, 0.2, 0.5, 1.0, 3.0)
_STARTS = ("squashed to a tenth", "flat", "inside out", "random")
_THRESHOLD = 0.1
# Laws whose energy is infinite at a stretch of zero and nothing below.
_LOGARITHMIC = ("neo-Hookean", "user's energy", "Mooney-Rivlin")
# The plane-strain modulus λ + 2 μ.
_MODULUS = lame(YOUNG, POISSON)[1] + 2.0 * lame(YOUNG, POISSON)[0]


def cases(*, quick: bool) -> list[Case]:
    """All cells of the three sweeps."""
    models = ("linear", "invertible StVK") if quick else tuple(MODELS)
    stretches = (0.5, 0.0) if quick else _STRETCHES
    found = [
        _case(CRUSH_TITLE, model, f"{stretch:g}", partial(crush, model, stretch))
        for model in models
        for stretch in stretches
    ]
    found += [
        _case(LOAD_TITLE, model, f"{load:g}", partial(press, model, load))
        for model in models
        if model != "mass-spring"
        for load in ((0.19,) if quick else _LOADS)
    ]
    starts = _STARTS[1:2] if quick else _STARTS
    for name, newton in (("converged", None), ("1 iteration", 1))[: 1 if quick else 2]:
        found += [
            _case(f"{BACK_TITLE}: {name}", model, start, partial(recover, model, start, newton))
            for model in models
            for start in starts
            if not (quick and model == "linear")
        ]
    return found


def _case(sweep: str, row: str, column: str, compute: partial) -> Case:
    return Case(sweep=sweep, row=row, column=column, compute=compute)


def column(model: str) -> fem.Solid:
    """Two cubes of 1 m, one on the other, between walls: only heights change."""
    walls = [fem.Fixed("z>-1", "xy"), fem.Fixed("z<1e-6", "z")]
    return fem.Solid(box((1, 1, 2), (1.0, 1.0, 2.0)), material(model), fixed=walls)


def stress(model: str, stretch: float) -> float:
    """Stress [Pa] between walls at a stretch of the height, by the laws' closed forms."""
    if model == "mass-spring":
        return _spring_stress(stretch)
    invertible = model.startswith("invertible")
    least = _THRESHOLD if invertible else -np.inf
    at = np.array([1.0, 1.0, max(stretch, least)])
    value = principal_stress(model, at, young=YOUNG, poisson=POISSON)[2]
    if stretch < least:  # the continuation is linear, with the slope at the threshold
        ahead, behind = (
            principal_stress(model, at + shift * np.eye(3)[2], young=YOUNG, poisson=POISSON)[2]
            for shift in (1e-6, -1e-6)
        )
        value += (ahead - behind) / 2e-6 * (stretch - least)
    return float(value)


def _spring_stress(stretch: float) -> float:
    """Of a cube's 4 upright edges (E/10) and 8 upright face diagonals (E/5).

    Each shared face or edge counts in full, for the column stands alone.
    """
    upright = 4 * 0.1 * YOUNG * (abs(stretch) - 1.0) * np.sign(stretch)
    length = np.sqrt(1.0 + stretch**2)
    slanted = 8 * 0.2 * YOUNG * (length - np.sqrt(2.0)) * stretch / length
    return float(upright + slanted)


def crush(model: str, stretch: float) -> Measured:
    """Prescribed height, in twenty parts: the force of the top against the closed form."""
    solid = column(model)
    top = analysis.Prescribed("z>1.999999", (None, None, 2.0 * (stretch - 1.0)))
    found = analysis.static_equilibrium(solid, [], prescribed=[top], load_steps=20)
    at_top = solid.points[:, 2] > 2.0 - 1e-6
    force = float(found.reactions[at_top, 2].sum())
    middle = np.abs(solid.points[:, 2] - 1.0) < 1e-6
    heights = 1.0 + found.displacement[middle, 2]
    if model in _LOGARITHMIC and stretch <= 0.0:
        # The law has no such state: what comes must not look like one.
        energy = found.strain_energy
        wrong = "the law has no state there, yet an equilibrium was returned"
        error = 1.0 if np.isfinite(energy) else np.nan
        return Measured(error=error, wrong=wrong, note=f"strain energy {energy}")
    error = abs(force - stress(model, stretch)) / YOUNG
    uneven = float(np.abs(heights - stretch).max())
    note = _stability(found)
    if uneven > EXACT:
        # Another equilibrium than the even one, where that is not stable.
        note += f", another equilibrium: uneven by {uneven:.2g}"
        return Measured(error=max(error, uneven), note=note)
    return Measured(error=error, theory=error, note=note)


def _stability(found: analysis.Equilibrium) -> str:
    return {True: "stable", False: "said to be unstable", None: ""}[found.definite]


def press(model: str, load: float) -> Measured:
    """A dead pressure on the top: the height against the branch that comes from rest.

    Where that branch has ended, no result is right.
    """
    solid = column(model)
    weight = analysis.Traction("z>1.999999", (0.0, 0.0, -load * _MODULUS))
    with listen() as said:
        found = analysis.static_equilibrium(solid, [weight], load_steps=20)
    top = solid.points[:, 2] > 2.0 - 1e-6
    height = 1.0 + float(found.displacement[top, 2].mean()) / 2.0
    exact = branch(model, -load * _MODULUS)
    note = f"stretch {height:.3g}, {_stability(found)}"
    note += "".join(f"; said: {message}" for message in said if "inside out" in message)
    if exact is None:
        silent = "inside out" not in note and found.definite is not False
        wrong = f"no equilibrium comes from rest, got a stretch of {height:.3g}" if silent else ""
        return Measured(error=1.0, wrong=wrong, note=note)
    return Measured(error=abs(height - exact), note=note)


@lru_cache(maxsize=64)
def branch(model: str, pressure: float) -> float | None:
    """Stretch at which a law bears a stress [Pa], followed from rest; None beyond its limit."""
    low = 1e-3 if model in _LOGARITHMIC else -6.0
    way = np.linspace(1.0, low, 3001)
    borne = np.array([stress(model, s) for s in way])
    limit = np.flatnonzero(np.diff(borne) > 0.0)
    end = len(way) if not limit.size else int(limit[0]) + 1
    if borne[:end].min() > pressure:
        return None
    return float(np.interp(-pressure, -borne[:end], way[:end]))


def recover(model: str, start: str, newton: int | None) -> Measured:
    """A cube let go from an impossible shape; damped, it must come back to rest."""
    solid = fem.Solid(box((2, 2, 2), (1.0, 1.0, 1.0)), material(model), fixed=["z<1e-6"])
    x = solid.points
    random = np.random.default_rng(1).uniform(0.0, 1.0, x.shape)
    places = {
        "squashed to a tenth": x * (1.0, 1.0, 0.1),
        "flat": x * (1.0, 1.0, 0.0),
        "inside out": x * (1.0, 1.0, -1.0),
        "random": random,
    }
    displacement = np.where(solid.held, 0.0, places[start] - x)
    period = np.sqrt(DENSITY / YOUNG)
    motion = analysis.simulate(
        solid,
        [],
        analysis.BackwardEuler(),
        step=0.5 * period,
        duration=100.0 * period,
        newton=newton,
        damping=(0.2 / period, 0.0),
        initial=analysis.Initial(displacement=displacement),
        energies_every=0,
    )
    away = float(np.abs(motion.state.displacement).max())
    energy = solid.energy(motion.state.displacement)
    if not np.isfinite(energy):
        return Measured(error=np.nan, note=f"moved by {away:.2g} of its edge, energy {energy}")
    return Measured(error=away, note=f"strain energy left {energy / YOUNG:.1e} E m³")
