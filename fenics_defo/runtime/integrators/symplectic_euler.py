"""Euler's symplectic method."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.explicit_forces import ExplicitForces
from fenics_defo.runtime.integrators.explicit_stepper import ExplicitStepper
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel

Array = NDArray[np.float64]


class SymplecticEuler(ExplicitStepper):
    """v' = v + h M⁻¹ (g - f(q) - C v),  q' = q + h v'.

    Explicit, of first order; it takes the load at the start of a step. It walks through the same
    coordinates as central differences with velocities half a step late, so that its energy
    oscillates by O(h) but does not drift. Stable below 2/ω (√(1 + ξ²) - ξ) with ξ = beta ω / 2.

    Args:
        model: what moves, of r coordinates.
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.
        energies: whether `energies` is asked for.
        allow_unstable: go on where the step is beyond the limit.

    Raises:
        LoadError: damping or arrays out of range.
        StepSizeError: the step is not positive and finite, or beyond `critical_step`.
        SolverError: a mass that is not positive definite.

    References: Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), section I.1.
    """

    load_at_start: ClassVar[bool] = True

    def _scheme_type(self) -> type["SymplecticStep"]:
        return SymplecticStep


class SymplecticStep:
    """A scheme: forces at the start of the step.

    x = M⁻¹ (g - f(q) - beta K(q) v),  a' = (x - alpha v) / (1 + alpha h),  v' = v + h a',
    q' = q + h v'

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
        part = 1.0 / (1.0 + damping[0] * step)
        x, q, v = np.eye(3)
        a = part * (x - damping[0] * v)
        v = v + step * a
        self._matrix = np.ascontiguousarray([q + step * v, v, a])
        self._rows = np.zeros((2, 4, *shape))  # x, q, v, a, twice
        flat = self._rows.reshape(2, 4, -1)
        self._views = tuple(
            (flat[at, :3], flat[1 - at, 1:], *self._rows[at, :3], flat[at, 0]) for at in range(2)
        )
        self._at, self._trial = 0, np.zeros(shape)

    @property
    def q(self) -> Array:
        """Coordinates."""
        return np.asarray(self._rows[self._at, 1])

    @property
    def v(self) -> Array:
        """Velocities."""
        return np.asarray(self._rows[self._at, 2])

    @property
    def a(self) -> Array:
        """Accelerations."""
        return np.asarray(self._rows[self._at, 3])

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""
        rows = self._rows[self._at]
        rows[1], rows[2], rows[3] = q, v, a
        self.here.forget()

    def trial(self) -> Array:
        """What the last step solved for."""
        return self._trial

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""
        before, after, x, q, v, flat = self._views[self._at]
        self._forces.into(x, load, q, v)
        np.dot(self._matrix, before, after)
        self._trial = x
        size: float = flat.dot(flat)
        if size < np.inf:
            self._at = 1 - self._at
        return size
