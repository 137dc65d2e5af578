"""Integrators as rows of a table, and a motion without loads that they are tried on."""

from dataclasses import dataclass

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Method:
    """An integrator and how its equations are solved.

    Args:
        integrator: of the package.
        newton: iterations a step; None: until converged.
        allow_unstable: whether an explicit method may go beyond its limit.
    """

    integrator: analysis.Integrator
    newton: int | None = 1
    allow_unstable: bool = False


METHODS = {
    "Newmark, 1 iteration": Method(analysis.ImplicitNewmark()),
    "Newmark, converged": Method(analysis.ImplicitNewmark(), None),
    "Newmark γ 0.6, converged": Method(analysis.ImplicitNewmark(beta=0.3025, gamma=0.6), None),
    "backward Euler, converged": Method(analysis.BackwardEuler(), None),
    "central differences": Method(analysis.CentralDifferences()),
    "symplectic Euler": Method(analysis.SymplecticEuler()),
}


@dataclass(frozen=True, slots=True)
class Path:
    """A motion that was done.

    Args:
        times: (k + 1,) [s].
        displacement: (k + 1, n, 3) [m].
        growth: largest total energy over the first [-].
        drift: largest change of the total energy over the first [-].
        residual: largest relative residual that a step reported [-].
    """

    times: Array
    displacement: Array
    growth: float
    drift: float
    residual: float


def free_motion(
    solid: fem.Solid,
    method: Method,
    *,
    step: float,
    count: int,
    velocity: Array,
    displacement: Array | None = None,
    **options: object,
) -> Path:
    """Steps without loads or damping from an initial motion."""
    fields: list[Array] = []
    motion = analysis.simulate(
        solid,
        [],
        method.integrator,
        step=step,
        duration=step * count,
        newton=method.newton,
        initial=analysis.Initial(displacement=displacement, velocity=velocity),
        energies_every=max(count // 50, 1),
        allow_unstable=method.allow_unstable,
        observe=lambda simulation: fields.append(simulation.state.displacement),
        **options,
    )
    total = motion.energies.kinetic + motion.energies.strain
    residuals = [report.residuals[-1] for report in motion.reports if report.residuals]
    return Path(
        times=motion.times,
        displacement=np.array(fields),
        growth=float(np.max(total) / total[0]),
        drift=float(np.abs(total / total[0] - 1.0).max()),
        residual=max(residuals, default=0.0),
    )
