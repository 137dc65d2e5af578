"""A hundred thousand steps without damping."""

from functools import partial

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS
from workflows.stability_map.outcomes import Measured
from workflows.stability_map.references import oscillator, spectrum

TITLE = "Steps without damping"
_AMPLITUDE = 0.1
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
_WAYS = (
    ("linear", "central differences"),
    ("St. Venant-Kirchhoff", "symplectic Euler"),
    ("St. Venant-Kirchhoff", "Newmark, 1 iteration"),
)


def cases(*, quick: bool) -> list[Case]:
    """All cells; the quick ones stop after a thousandth of the steps."""
    return [
        Case(
            sweep=TITLE,
            row=f"{model}, {name}",
            column=f"{count:.0e}",
            compute=partial(cell, model, name, count),
            patience=3600.0,
        )
        for model, name in (_WAYS[:1] if quick else _WAYS)
        for count in ((300,) if quick else (1000, 100_000))
    ]


def cell(model: str, name: str, count: int) -> Measured:
    """One tetrahedron on its foot, ten steps a radian of its lowest mode.

    The linear body is compared with the exact discrete motion of its mode, of the others the
    drift is asked: the change of the energy's mean between the first and the last tenth.
    """
    method = METHODS[name]
    mesh = fem.build_mesh(_CORNERS, [[0, 1, 2, 3]])
    solid = fem.Solid(mesh, material(model), fixed=["z<1e-6"])
    modes = spectrum(solid, lumped=method.integrator.explicit)
    omega = modes.omega[0]
    step = min(0.1 / omega, 0.9 / modes.omega[-1])
    motion = analysis.simulate(
        solid,
        [],
        method.integrator,
        step=step,
        duration=step * count,
        newton=method.newton,
        initial=analysis.Initial(velocity=_AMPLITUDE * omega * modes.shapes[0]),
        energies_every=max(count // 2000, 1),
        probes={"tip": (0.0, 0.0, 1.0)},
    )
    total = motion.energies.kinetic + motion.energies.strain
    tenth = len(total) // 10
    drift = abs(total[-tenth:].mean() / total[:tenth].mean() - 1.0)
    swing = float(np.ptp(total) / total.mean())
    theory = 0.0
    if model == "linear":
        path = _AMPLITUDE * oscillator(method.integrator, omega, step, count)
        theory = float(np.abs(motion.probes["tip"] - path[:, None] * modes.shapes[0][3]).max())
        theory /= _AMPLITUDE
    note = f"energy drifts by {drift:.1e} and swings by {swing:.1e}"
    if model == "linear":
        note += f", {theory:.1e} from the exact discrete motion"
    return Measured(error=drift, theory=theory, growth=float(np.max(total) / total[0]), note=note)
