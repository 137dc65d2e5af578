"""A free bar that spins fast, all but rigid."""

from dataclasses import dataclass
from functools import lru_cache, partial

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import DENSITY, FEW, YOUNG, Array, box, material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, Method
from workflows.stability_map.outcomes import Measured

TITLE = "Spin, radians a step"
# ρ Ω² L² / E: the strains of the spin.
_STRAIN = 1e-4
_ANGLES = (1e-3, 1e-2, 0.1, 0.5, 1.0)
_MODELS = (
    *FEW,
    "corotational, approximate",
    "neo-Hookean",
    "user's energy",
    "invertible StVK",
    "mass-spring",
)
_METHODS = (
    "Newmark, 1 iteration",
    "Newmark, converged",
    "backward Euler, converged",
    "central differences",
)
# Steps of a cell, or fewer where they make two turns.
_MOST = 60


def cases(*, quick: bool) -> list[Case]:
    """All cells."""
    models = FEW[2:] if quick else _MODELS
    names = _METHODS[1::2] if quick else _METHODS
    return [
        Case(
            sweep=f"{TITLE}: {name}",
            row=model,
            column=f"{angle:g}",
            compute=partial(cell, model, name, angle),
        )
        for name in names
        for model in models
        for angle in ((0.1,) if quick else _ANGLES)
    ]


@lru_cache(maxsize=1)
def bar(model: str) -> fem.Solid:
    """A free bar of 2 m about the origin."""
    mesh = box((2, 1, 1), (2.0, 1.0, 1.0))
    return fem.Solid(mesh, material(model))


def cell(model: str, name: str, angle: float) -> Measured:
    """Error of the places against those of a rigid body, over the bar's half length."""
    method, solid = METHODS[name], bar(model)
    rate = np.sqrt(_STRAIN * YOUNG / DENSITY)
    count = int(np.clip(round(4.0 * np.pi / angle), 30, _MOST))
    arm = solid.points - solid.points.mean(axis=0)
    velocity = rate * np.column_stack([-arm[:, 1], arm[:, 0], np.zeros(len(arm))])
    path = _path(method, solid, velocity, angle / rate, count)
    turn = rate * path.times[:, None]
    x = np.cos(turn) * arm[:, 0] - np.sin(turn) * arm[:, 1]
    y = np.sin(turn) * arm[:, 0] + np.cos(turn) * arm[:, 1]
    rigid = np.stack([x, y, np.broadcast_to(arm[:, 2], x.shape)], axis=2)
    places = path.displacement + arm
    error = float(np.linalg.norm(places - rigid, axis=2).max())
    size = np.linalg.norm(places, axis=2).max() / np.linalg.norm(arm, axis=1).max()
    note = f"angular momentum changes by {path.spin:.1e}, largest size {size:.3g}"
    if model == "linear":
        # To this law a spin is a motion on straight lines, without strain: it is exact for it.
        straight = path.times[:, None, None] * velocity
        theory = float(np.abs(path.displacement - straight).max() / np.abs(straight).max())
        return Measured(error=error, theory=theory, growth=path.growth, note=note)
    return Measured(error=error, growth=max(path.growth, float(size)), note=note)


@dataclass(frozen=True, slots=True)
class _Spin:
    """A spin that was done.

    Args:
        times: (k + 1,) [s].
        displacement: (k + 1, n, 3) [m].
        growth: largest energy over the first [-].
        spin: largest change of the angular momentum over the first [-].
    """

    times: Array
    displacement: Array
    growth: float
    spin: float


def _path(method: Method, solid: fem.Solid, velocity: Array, step: float, count: int) -> _Spin:
    fields: list[Array] = []
    momenta: list[float] = []

    def observe(simulation: analysis.Simulation) -> None:
        fields.append(simulation.state.displacement)
        momenta.append(float(simulation.momentum()[1][2]))

    motion = analysis.simulate(
        solid,
        [],
        method.integrator,
        step=step,
        duration=step * count,
        newton=method.newton,
        initial=analysis.Initial(velocity=velocity),
        energies_every=1,
        observe=observe,
    )
    total = motion.energies.kinetic + motion.energies.strain
    return _Spin(
        times=motion.times,
        displacement=np.array(fields),
        growth=float(np.max(total) / total[0]),
        spin=float(np.abs(np.array(momenta) / momenta[0] - 1.0).max()),
    )
