"""Implicit steps by Newton's method until the residual is small."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.dense_solver import solve
from fenics_defo.runtime.integrators.implicit_rule import ImplicitRule
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Here

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
# What the forces at the start of the step leave as round-off in those at its end.
_START_ROUND_OFF = 1e3 * _EPS
# Forces of round-off in the coordinates that count as none, in units of eps |K| |q|; to those in
# the accelerations, one unit of eps |M| |q| times their rate is added.
_ROUND_OFF = 10.0
# A residual that grows beyond this multiple of the first will not come back.
_HOPELESS = 1e10
_CUTS = 12
# The slope along a search direction must fall to this part of what it was.
_SLOPE = 0.7


class _Balance:
    """Motion and forces at an iterate.

    Args:
        step: the scheme.
        q: the iterate.
        load: generalised force.
    """

    def __init__(self, step: "ConvergedStep", q: Array, load: Array) -> None:
        rule, (alpha, beta), start = step.rule, step.damping, step.start
        change = q - start[0]
        force, stiffness = step.here.evaluate(q)
        self.q, self.stiffness = q, stiffness
        self.v = step.still_v + rule.velocity_rate * change
        self.a = step.still_a + rule.acceleration_rate * change
        inertia = step.inertia.apply(self.a)
        drag = alpha * step.inertia.apply(self.v)
        drag += beta * (stiffness @ self.v[..., None])[..., 0]
        self.residual = inertia + drag + force - load
        terms = np.stack([inertia, drag, force, np.broadcast_to(load, q.shape)])
        #: ‖residual‖ and the largest norm of the terms (...).
        self.size = np.linalg.norm(self.residual, axis=-1)
        self.scale = np.linalg.norm(terms, axis=-1).max(axis=0)


class ConvergedStep:
    """A scheme: iterates until ‖r‖ <= tolerance max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖), each body on its own.

    Full steps are tried first; a body for which they fail is done again with a search along the
    direction for where the residual is orthogonal to it.

    Args:
        model: what moves.
        inertia: its mass.
        rule: the method's.
        damping: (alpha [1/s], beta [s]).
        tolerance: largest relative residual.
        most: largest number of iterations.
        shape: of the coordinates.
    """

    def __init__(
        self,
        model: MotionModel,
        inertia: Inertia,
        rule: ImplicitRule,
        *,
        damping: tuple[float, float],
        tolerance: float,
        most: int,
        shape: tuple[int, ...],
    ) -> None:
        self.here = Here(model, shape, tangent=True)
        self.inertia, self.rule, self.damping = inertia, rule, damping
        self._model, self._tolerance, self._most = model, tolerance, most
        self._scale = 1.0 + damping[1] * rule.velocity_rate
        mass_scale = rule.acceleration_rate + damping[0] * rule.velocity_rate
        self._mass = mass_scale * inertia.matrix
        self._noisy_mass = rule.acceleration_rate * np.abs(inertia.matrix)
        #: Rows q, v, a at the start of the step.
        self.start = np.zeros((3, *shape))
        #: Velocity and acceleration where the displacement is that at the start.
        self.still_v = self.still_a = np.zeros(shape)
        self._trial = np.zeros(shape)
        #: Linear solves of the last step.
        self.iterations = 0

    @property
    def q(self) -> Array:
        """Coordinates."""
        return np.asarray(self.start[0])

    @property
    def v(self) -> Array:
        """Velocities."""
        return np.asarray(self.start[1])

    @property
    def a(self) -> Array:
        """Accelerations."""
        return np.asarray(self.start[2])

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""
        self.start[0], self.start[1], self.start[2] = q, v, a
        self.here.forget()

    def trial(self) -> Array:
        """The last iterate, not finite for bodies whose step failed."""
        return self._trial

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""
        rule, (_, v, a) = self.rule, self.start
        self.still_v = rule.velocity_of_v * v + rule.velocity_of_a * a
        self.still_a = rule.acceleration_of_v * v + rule.acceleration_of_a * a
        self.iterations = 0
        self.here.forget()
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            reached = self._newton(load, search=False)
            failed = ~np.isfinite(reached).all(axis=(0, -1))
            if failed.any():
                reached = self._again(load, reached, failed)
        self._trial = reached[0]
        size = float(np.vdot(reached, reached))
        if size < np.inf:
            self.start[...] = reached
        return size

    def _again(self, load: Array, reached: Array, failed: NDArray[np.bool_]) -> Array:
        """The bodies that failed, one by one, with a search."""
        if self.start.ndim == 2:
            return self._newton(load, search=True)
        single = ConvergedStep(
            self._model,
            self.inertia,
            self.rule,
            damping=self.damping,
            tolerance=self._tolerance,
            most=self._most,
            shape=self.start.shape[-1:],
        )
        loads = np.broadcast_to(load, self.start.shape[1:])
        for body in np.flatnonzero(failed):
            single.place(*self.start[:, body])
            if single.advance(loads[body]) < np.inf:
                reached[:, body] = single.start
            self.iterations = max(self.iterations, single.iterations)
        return reached

    def _newton(self, load: Array, *, search: bool) -> Array:
        """Rows q, v, a at the end, NaN for bodies for which it was not found."""
        balance = _Balance(self, self.start[0].copy(), load)
        first = balance.scale
        for iteration in range(self._most):
            open_ = self._is_open(balance, first)
            if iteration and not open_.any():
                break
            # The first change is made even where nothing seems to be left to solve.
            moving = open_ if iteration else np.ones_like(open_)
            direction = self._direction(balance) * moving[..., None]
            q = self._searched(balance, direction, load) if search else balance.q + direction
            balance = _Balance(self, q, load)
            self.iterations += 1
            # Also where it is no number.
            hopeless = ~(balance.size <= _HOPELESS * np.maximum(first, balance.scale))
            balance.q[hopeless] = np.nan
            if hopeless.all():
                break
        balance.q[self._is_open(balance, first)] = np.nan
        return np.stack([balance.q, balance.v, balance.a])

    def _is_open(self, balance: _Balance, first: Array) -> NDArray[np.bool_]:
        """Whether the equations do not hold yet (...); true where something is no number."""
        allowed = np.maximum(self._tolerance * balance.scale, _START_ROUND_OFF * first)
        noise = _ROUND_OFF * np.abs(balance.stiffness) + self._noisy_mass
        forces = (noise @ np.abs(balance.q)[..., None])[..., 0]
        allowed = np.maximum(allowed, _EPS * np.linalg.norm(forces, axis=-1))
        return np.asarray(~(balance.size <= allowed))

    def _direction(self, balance: _Balance) -> Array:
        direction = np.full_like(balance.q, np.nan)
        matrix = self._scale * balance.stiffness + self._mass
        try:
            solve(matrix, -balance.residual, direction)
        except np.linalg.LinAlgError:
            direction[...] = np.nan
        return direction

    def _searched(self, balance: _Balance, direction: Array, load: Array) -> Array:
        """The next iterate along a direction, for one body; NaN if there is none."""
        slope, length = float(direction @ balance.residual), 1.0
        if slope > 0.0:  # uphill, for the matrix was not positive definite
            direction, slope = -direction, -slope
        q = balance.q
        for _ in range(_CUTS):
            trial = q + length * direction
            ahead = float(direction @ _Balance(self, trial, load).residual)
            if not np.isfinite(ahead):
                length *= 0.5
                continue
            if ahead <= _SLOPE * abs(slope):
                return trial
            # Regula falsi between here and there, kept off both ends.
            length *= min(max(slope / (slope - ahead), 0.1), 0.6)
        return np.full_like(q, np.nan)
