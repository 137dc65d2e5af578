"""The inner part of an integrator: state and one step, without checks and bookkeeping."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.motion_model import MotionModel

Array = NDArray[np.float64]


class Scheme(Protocol):
    """State and step of a method.

    ``q``, ``v``, ``a`` are of the shape of the coordinates; their arrays are the scheme's own and
    may change with the next step. `Here` tells the forces at the state.
    """

    @property
    def q(self) -> Array:
        """Coordinates."""

    @property
    def v(self) -> Array:
        """Velocities."""

    @property
    def a(self) -> Array:
        """Accelerations."""

    @property
    def here(self) -> "Here":
        """Forces at the state."""

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""

    def trial(self) -> Array:
        """What the last step solved for, of the shape of q: tells whose step failed."""


class Here:
    """Force and tangent at a scheme's present state, computed once.

    Args:
        model: what moves.
        shape: of the coordinates.
        tangent: whether the scheme itself needs K(q).
    """

    def __init__(self, model: MotionModel, shape: tuple[int, ...], *, tangent: bool) -> None:
        evaluator = model.law.evaluator(shape)
        #: f(q), and f(q) and K(q), in buffers that the next call overwrites.
        self.evaluate_force = evaluator.force
        self.evaluate = evaluator.force_and_stiffness
        self._tangent = tangent
        #: f(q) if known: a scheme takes it and forgets it.
        self.force: Array | None = None
        #: f(q) and K(q) if known.
        self.both: tuple[Array, Array] | None = None

    def forget(self) -> None:
        """The state has changed."""
        self.force = self.both = None

    def force_at(self, q: Array) -> Array:
        """Force f(q) at the present state; valid until the next call of anything here."""
        if self._tangent:
            return self._both_at(q)[0]
        if self.force is None:
            self.force = self.evaluate_force(q)
        return self.force

    def stiffness_times(self, q: Array, vector: Array) -> Array:
        """K at the present state q times a vector of its shape, as a new array."""
        stiffness = self._both_at(q)[1]
        return np.asarray((stiffness @ vector[..., None])[..., 0])

    def stiffness_at(self, q: Array) -> Array:
        """K at the present state q; valid until the next call of anything here."""
        return self._both_at(q)[1]

    def _both_at(self, q: Array) -> tuple[Array, Array]:
        if self.both is None:
            self.both = self.evaluate(q)
            self.force = self.both[0]
        return self.both
