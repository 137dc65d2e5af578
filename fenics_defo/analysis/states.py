"""What a simulation hands out: states, energies, reports, motions and equilibria, as NumPy data."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class State:
    """Motion of a body at one time, over the nodes in the user's order.

    Together with `Energies` it is all that a restart needs.

    Args:
        time: [s].
        step: number of steps done since time zero.
        displacement: (n, 3) [m].
        velocity: (n, 3) [m/s].
        acceleration: (n, 3) [m/s²].
    """

    time: float
    step: int
    displacement: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies of a body at one time [J].

    kinetic + strain - their values at the start = external - dissipated, but for the error of the
    integrator.

    Args:
        kinetic: ½ vᵀ M v.
        strain: of the material (and of its springs).
        external: work of loads, impulses and prescribed motions since time zero.
        dissipated: ∫ vᵀ C v dt by Rayleigh damping since time zero.
    """

    kinetic: float
    strain: float
    external: float
    dissipated: float

    @property
    def balance(self) -> float:
        """Kinetic + strain + dissipated - external [J]: constant but for the integrator's error."""
        return self.kinetic + self.strain + self.dissipated - self.external


@dataclass(frozen=True, slots=True)
class Substep:
    """A part of a step that was done at once; the whole step unless it had to be halved.

    Args:
        time: at its end [s].
        residuals: relative residual ‖r‖ / max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖) before each solve of Newton's
            method and after the last; none for explicit methods.
    """

    time: float
    residuals: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class StepReport:
    """How one step went.

    Args:
        time: at its end [s].
        step: its number, from 1.
        newton_iterations: linear solves, those of failed attempts included; 0 for explicit methods.
        linear_iterations: conjugate gradient iterations of them; 1 a solve by the direct solver.
        halvings: how often the step was halved.
        substeps: its parts.
    """

    time: float
    step: int
    newton_iterations: int
    linear_iterations: int
    halvings: int
    substeps: tuple[Substep, ...]

    @property
    def residuals(self) -> tuple[float, ...]:
        """Relative residuals of the last part."""
        return self.substeps[-1].residuals


@dataclass(frozen=True, slots=True)
class EnergyRecord:
    """Energies over time.

    Args:
        times: (m,) [s].
        kinetic: (m,) [J].
        strain: (m,) [J].
        external: (m,) [J].
        dissipated: (m,) [J].
    """

    times: Array
    kinetic: Array
    strain: Array
    external: Array
    dissipated: Array

    @property
    def balance(self) -> Array:
        """Kinetic + strain + dissipated - external (m,) [J]."""
        return self.kinetic + self.strain + self.dissipated - self.external


@dataclass(frozen=True, slots=True)
class Motion:
    """What `simulate` returns: k steps.

    Args:
        times: (k + 1,) [s], the start first.
        probes: displacement (k + 1, 3) [m] by the probe's name.
        energies: those recorded.
        state: at the end.
        reports: (k) of them.
        energy_error: largest error of the energy balance over all energy put in [-], see
            `Simulation.energy_error`; None for equilibria.
        energy_gain: the same of what was gained [-].
    """

    times: Array
    probes: Mapping[str, Array]
    energies: EnergyRecord
    state: State
    reports: tuple[StepReport, ...]
    energy_error: float | None
    energy_gain: float | None


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """A state of rest under loads.

    Args:
        displacement: (n, 3) [m].
        reactions: (n, 3) [N], forces of the supports upon the body; zero at free components.
        strain_energy: [J].
        load_factors: (s,) parts of the load at which equilibrium was found, the last one 1.
        residuals: relative residuals of Newton's iterations, one tuple a load factor.
        iterations: linear solves in all.
        definite: whether its tangent K - dg/du is positive definite, as that of a stable
            equilibrium is; None if the solver cannot tell, or a law's tangent is not its own
            ("definite" or "approximate").
        inverted_cells: number of cells that are inside out at one of their corners at least.
    """

    displacement: Array
    reactions: Array
    strain_energy: float
    load_factors: tuple[float, ...]
    residuals: tuple[tuple[float, ...], ...]
    iterations: int
    definite: bool | None
    inverted_cells: int
