"""A model on its way through equilibria, as slow loads pass through them; NumPy only."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.instant import Instant, StepFailure
from fenics_defo.analysis.states import Energies
from fenics_defo.analysis.substeps import run_substeps
from fenics_defo.runtime import ReducedModel
from fenics_defo.runtime.integrators.converged_step import ConvergedStep
from fenics_defo.runtime.integrators.implicit_rule import ImplicitRule
from fenics_defo.runtime.integrators.inertia import Inertia

Array = NDArray[np.float64]

_AT_REST = ImplicitRule(
    velocity_rate=0.0,
    acceleration_rate=0.0,
    velocity_of_v=0.0,
    velocity_of_a=0.0,
    acceleration_of_v=0.0,
    acceleration_of_a=0.0,
)


class ReducedStatics:
    """f(q) = g(t) of a model, one load step after the other; a step that fails is halved.

    Args:
        model: model.
        force: reduced load (r,) at a time [s].
        q: coordinates to start from (r,).
        step: load step [s].
        tolerance: largest ‖f - g‖ / max(‖f‖, ‖g‖) [-].
        iterations: most solves an equilibrium.
        halvings: how often a step may be halved.
    """

    def __init__(
        self,
        model: ReducedModel,
        force: Callable[[float], Array],
        *,
        q: Array,
        step: float,
        tolerance: float,
        iterations: int,
        halvings: int = 6,
    ) -> None:
        self._model, self._force, self._step, self._most = model, force, step, halvings
        shape = (model.size,)
        self._scheme = ConvergedStep(
            model,
            Inertia(model.mass, shape),
            _AT_REST,
            damping=(0.0, 0.0),
            tolerance=tolerance,
            most=iterations,
            shape=shape,
        )
        self._nothing = np.zeros(shape)
        self._now = Instant(0.0, np.array(q), self._nothing, self._nothing)
        self._external = 0.0
        self.steps = 0
        #: Linear solves, and halvings, of the last step.
        self.iterations = self.halvings = 0

    @property
    def time(self) -> float:
        """How far the loads are [s]."""
        return self._now.time

    @property
    def q(self) -> Array:
        """Coordinates (r,)."""
        return self._now.displacement

    @property
    def v(self) -> Array:
        """Zeros (r,)."""
        return self._nothing

    @property
    def a(self) -> Array:
        """Zeros (r,)."""
        return self._nothing

    @property
    def energies(self) -> Energies:
        """Strain energy, and the loads' work by trapezoids."""
        return Energies(0.0, float(self._model.energy(self.q)), self._external, 0.0)

    def advance(self) -> None:
        """Do one load step.

        Raises:
            DivergenceError: it failed however often it was halved; the last equilibrium stands.
        """
        self.iterations = 0
        end = (self.steps + 1) * self._step
        self.halvings = run_substeps(
            self._now, end, advance=self._substep, keep=self._keep, most=self._most
        )
        self.steps += 1

    def _substep(self, start: Instant, length: float) -> Instant:
        scheme, time = self._scheme, start.time + length
        scheme.place(start.displacement, self._nothing, self._nothing)
        size = scheme.advance(self._force(time))
        self.iterations += scheme.iterations
        if not size < np.inf:
            raise StepFailure("Newton's method did not converge on the model")
        return Instant(time, np.array(scheme.q), self._nothing, self._nothing)

    def _keep(self, start: Instant, reached: Instant) -> None:
        change = reached.displacement - start.displacement
        mean = 0.5 * (self._force(start.time) + self._force(reached.time))
        self._external += float(change @ mean)
        self._now = reached
