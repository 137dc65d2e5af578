"""Central differences."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.explicit_forces import ExplicitForces
from fenics_defo.runtime.integrators.explicit_stepper import ExplicitStepper
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel

Array = NDArray[np.float64]


class CentralDifferences(ExplicitStepper):
    """w = v + h/2 a,  q' = q + h w,  M a' = g' - f' - C w,  v' = w + h/2 a'.

    Explicit, of second order (of first in the stiffness part of the damping, which takes the
    velocity w from half a step earlier; its mass part takes v'). Stable below
    2/ω (√(1 + ξ²) - ξ) with ξ = beta ω / 2.

    Args:
        model: what moves, of r coordinates.
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise: gives the first
            acceleration.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.
        energies: whether `energies` is asked for.
        allow_unstable: go on where the step is beyond the limit.

    Raises:
        LoadError: damping or arrays out of range.
        StepSizeError: the step is not positive and finite, or beyond `critical_step`.
        SolverError: a mass that is not positive definite.

    References: Belytschko, Liu and Moran, Nonlinear Finite Elements (2000), section 6.2.
    """

    def _scheme_type(self) -> type["LeapfrogStep"]:
        return LeapfrogStep


class LeapfrogStep:
    """A scheme: forces at the end of the step, velocities w at its middle.

    w' = w + h a,  q' = q + h w',  x' = M⁻¹ (g' - f(q') - beta K(q') w'),
    a' = (x' - alpha w') / (1 + alpha h / 2),  v' = w' + h/2 a'

    Args:
        model: what moves.
        inertia: its mass.
        step: h [s].
        damping: (alpha [1/s], beta [s]).
        shape: of the coordinates.
    """

    def __init__(
        self,
        model: MotionModel,
        inertia: Inertia,
        *,
        step: float,
        damping: tuple[float, float],
        shape: tuple[int, ...],
    ) -> None:
        self._forces = ExplicitForces(model, inertia, damping[1], shape)
        self.here = self._forces.here
        self._step, self._alpha = step, damping[0]
        self._part = 1.0 / (1.0 + 0.5 * self._alpha * step)
        x, q, w = np.eye(3)
        w = w + step * (self._part * x - self._part * self._alpha * w)
        self._matrix = np.ascontiguousarray([q + step * w, w])
        self._rows = np.zeros((2, 3, *shape))  # x, q, w, twice
        flat = self._rows.reshape(2, 3, -1)
        self._views = tuple(
            (flat[at], flat[1 - at, 1:], *self._rows[1 - at], flat[1 - at, 0]) for at in range(2)
        )
        self._at, self._trial = 0, np.zeros(shape)

    @property
    def q(self) -> Array:
        """Coordinates."""
        return np.asarray(self._rows[self._at, 1])

    @property
    def v(self) -> Array:
        """Velocities."""
        return np.asarray(self._rows[self._at, 2] + 0.5 * self._step * self.a)

    @property
    def a(self) -> Array:
        """Accelerations."""
        x, _, w = self._rows[self._at]
        return np.asarray(self._part * (x - self._alpha * w))

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""
        rows = self._rows[self._at]
        rows[1], rows[2] = q, v - 0.5 * self._step * a
        rows[0] = a / self._part + self._alpha * rows[2]
        self.here.forget()

    def trial(self) -> Array:
        """What the last step solved for."""
        return self._trial

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""
        before, after, x, q, w, flat = self._views[self._at]
        self.here.force = self.here.both = None
        np.dot(self._matrix, before, after)
        self._forces.into(x, load, q, w)
        self._trial = x
        size: float = flat.dot(flat)
        if size < np.inf:
            self._at = 1 - self._at
        return size
