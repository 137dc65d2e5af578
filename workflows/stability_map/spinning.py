"""A free bar that spins fast, all but rigid."""

from functools import lru_cache, partial

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import DENSITY, FEW, MODELS, YOUNG, Array, box, material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, Method
from workflows.stability_map.outcomes import Measured

TITLE = "Spin, radians a step"
# ρ Ω² L² / E: the strains of the spin.
_STRAIN = 1e-4
_ANGLES = (1e-3, 1e-2, 0.1, 0.5, 1.0, 3.0)
# Steps of a cell, or fewer where they make two turns.
_MOST = 200


def cases(*, quick: bool) -> list[Case]:
    """All cells."""
    models = FEW if quick else tuple(MODELS)
    names = ("Newmark, converged", "backward Euler, converged", "central differences")
    return [
        Case(
            sweep=f"{TITLE}: {name}",
            row=model,
            column=f"{angle:g}",
            compute=partial(cell, model, name, angle),
        )
        for name in (names if quick else METHODS)
        for model in models
        for angle in ((1e-3, 0.1) if quick else _ANGLES)
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
    count = int(np.clip(round(4.0 * np.pi / angle), 20, _MOST))
    arm = solid.points - solid.points.mean(axis=0)
    velocity = rate * np.column_stack([-arm[:, 1], arm[:, 0], np.zeros(len(arm))])
    return _measured(method, solid, velocity, angle / rate, count, rate)


def _measured(
    method: Method, solid: fem.Solid, velocity: Array, step: float, count: int, rate: float
) -> Measured:
    places: list[Array] = []
    momenta: list[float] = []

    def observe(simulation: analysis.Simulation) -> None:
        places.append(solid.points + simulation.state.displacement)
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
    arm = solid.points - solid.points.mean(axis=0)
    turn = rate * motion.times[:, None]
    x = np.cos(turn) * arm[:, 0] - np.sin(turn) * arm[:, 1]
    y = np.sin(turn) * arm[:, 0] + np.cos(turn) * arm[:, 1]
    rigid = np.stack([x, y, np.broadcast_to(arm[:, 2], x.shape)], axis=2)
    away = np.array(places) - solid.points.mean(axis=0) - rigid
    total = motion.energies.kinetic + motion.energies.strain
    spin = float(np.abs(np.array(momenta) / momenta[0] - 1.0).max())
    # Where a step turns far, only size and energy can be asked for: the places' scale is the arm.
    size = np.linalg.norm(np.array(places) - solid.points.mean(axis=0), axis=2).max()
    swelling = float(size / np.linalg.norm(arm, axis=1).max())
    return Measured(
        error=float(np.linalg.norm(away, axis=2).max()),
        growth=max(float(np.max(total) / total[0]), swelling),
        note=f"angular momentum changes by {spin:.1e}, largest size {swelling:.3g}",
    )
