"""One step of a floating body: the trapezoidal rule in its momenta."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.inertia import Inertia, InertiaAtShape
from fenics_defo.runtime.floating.linearised import LinearisedStep
from fenics_defo.runtime.floating.loads import Loads, LoadsAtShape
from fenics_defo.runtime.floating.products import by, times, transposed
from fenics_defo.runtime.floating.rotations import exponential, orthonormalised, skew
from fenics_defo.runtime.floating.state import FloatingState
from fenics_defo.runtime.forces.force_law import ForceLaw
from fenics_defo.runtime.integrators.dense_solver import solve

Array = NDArray[np.float64]

# Turns as small as this [rad] need no more than the first order: the rest would be round-off.
_SMALL_TURN = 1e-7
_SPIN_ITERATIONS = 30


class StepFailure(Exception):
    """A step was not found; the message is a clause that says why."""


@dataclass(frozen=True, slots=True)
class NewtonSettings:
    """How Newton's method ends.

    Args:
        iterations: solves a step; None: until ``tolerance`` is met.
        tolerance: largest residual relative to the largest term, of q and of the spin alike.
        most: largest number of solves.
    """

    iterations: int | None
    tolerance: float
    most: int


class FloatingStep:
    """Steps of equal length h of a floating body.

    With p the momenta of q, g their rate, L the angular momentum in the world and w the spin,

        p' = p + h (g + g') / 2,             q' = q + h (v + v') / 2
        L' = L + h (moment + moment') / 2,   R' = R exp(h (w + w') / 2)

    where w' and v' are those that L' and p' belong to. The rule is symmetric in time and of second
    order. Without loads L is constant, so the angular momentum is kept to round-off however q was
    found; without rotation it is Newmark's method of average acceleration. One Newton iteration
    takes the elastic force linear about the start of the step, and the inertia forces about what
    constant rates would make of it: second order too.

    Args:
        law: elastic force of q.
        inertia: of the body.
        mass: of the body [kg].
        damping: (alpha [1/s], beta [s]); C = alpha M + beta K(q) acts on the rates of q.
        step: h [s].
        newton: how Newton's method ends.
        shape: shape of q, (r,) or (b, r).
    """

    def __init__(
        self,
        law: ForceLaw,
        inertia: Inertia,
        *,
        mass: float,
        damping: tuple[float, float],
        step: float,
        newton: NewtonSettings,
        shape: tuple[int, ...],
    ) -> None:
        self._evaluator = law.evaluator(shape)
        self.inertia = inertia
        self._mass = mass
        self._alpha, self._beta = damping
        self._h = step
        self._newton = newton
        self._damped = any(damping)
        nothing = np.zeros(shape[-1]), np.zeros((shape[-1], 3)), np.zeros((3, shape[-1]))
        self._no_damping, self._no_slopes = nothing[0], (*nothing[1:], np.zeros((3, 3)))
        weight = np.trace(inertia.mass) / max(len(inertia.mass), 1)
        turning = np.trace(inertia.at(nothing[0]).inertia) / 3.0
        self._scale = 2.0 / step * math.sqrt(weight / turning) if weight > 0.0 else 1.0
        self._heavy = (4.0 / step**2 + 2.0 / step * damping[0]) * inertia.mass
        self._stiff = 1.0 + 2.0 / step * damping[1]

    def begun(self, state: FloatingState, loads: Loads) -> FloatingState:
        """A state with the rates that its loads, acting from now, give it."""
        q, v, spin = state.q, state.v, state.spin
        force, stiffness = self._evaluator.force_and_stiffness(q)
        loaded = loads.at(q, state.rotation)
        slope = self.inertia.at(q).inertia_slope(spin)
        inertial = by(spin, self.inertia.gyroscopic_rows(v) + 0.5 * slope)
        return replace(
            state,
            push=inertial - force - self._damping(stiffness, v) + loaded.push,
            moment=times(state.rotation, loaded.moment),
            force=loads.resultant(self._mass),
        )

    def advance(self, start: FloatingState, loads: Loads) -> FloatingState:
        """The state one step later, under loads that act at its end.

        Raises:
            StepFailure: it was not found.
        """
        h = self._h
        half = start.angular + 0.5 * h * start.moment
        q, spin, bent = start.q + h * start.v, start.spin, start.q
        newton = self._newton
        most = newton.most if newton.iterations is None else newton.iterations
        for iteration in range(most):
            now = self._linearised(start, half, q, spin, bent, loads)
            if newton.iterations is None and iteration and now.excess() <= newton.tolerance:
                break
            change, turn = now.solved(self._scale)
            q, spin = q + change, spin + turn
            bent = q
        else:
            if newton.iterations is None and not (
                self._linearised(start, half, q, spin, bent, loads).excess() <= newton.tolerance
            ):
                raise StepFailure(f"Newton's method did not converge in {most} iterations")
        return self._ended(start, half, q, spin, loads)

    def _linearised(
        self,
        start: FloatingState,
        half: Array,
        q: Array,
        spin: Array,
        bent: Array,
        loads: Loads,
    ) -> LinearisedStep:
        """The equations about q and spin, with the elastic force linear about ``bent``."""
        h, inertia = self._h, self.inertia
        v = (2.0 / h) * (q - start.q) - start.v
        at = inertia.at(q)
        rows, slope = inertia.gyroscopic_rows(v), at.inertia_slope(spin)
        gyro, softening = inertia.turning(spin)
        force, stiffness = self._evaluator.force_and_stiffness(bent)
        rotation, jacobian = self._turned(start, spin)
        angular = times(transposed(rotation), half)
        loaded = loads.at(q, rotation)
        momenta = times(inertia.mass, v) + by(spin, at.coupling)
        elastic = force if bent is q else force + times(stiffness, q - bent)
        damping = self._damping(stiffness, v)
        inertial = (2.0 / h) * (momenta - start.momenta) - start.push
        shape = inertial - by(spin, rows + 0.5 * slope) + elastic + damping - loaded.push
        carried, deforming = times(at.inertia, spin), times(at.coupling, v)
        turning = carried + deforming - angular - 0.5 * h * loaded.moment
        terms = (elastic, damping, loaded.push, start.push, (2.0 / h) * momenta)
        by_q = self._heavy + self._stiff * stiffness - (4.0 / h) * gyro - softening
        push_turn, moment_q, moment_turn = self._slopes(loads, loaded)
        reach = 0.5 * h * jacobian
        moving, turned = (2.0 / h) * at.coupling, rows + slope
        return LinearisedStep(
            shape,
            turning,
            by_q,
            transposed(moving - turned) - push_turn @ reach,
            moving + turned - 0.5 * h * moment_q,
            at.inertia - (skew(angular) + 0.5 * h * moment_turn) @ reach,
            (terms, (carried, deforming, angular)),
        )

    def _damping(self, stiffness: Array, v: Array) -> Array:
        if not self._damped:
            return self._no_damping
        return times(self._alpha * self.inertia.mass + self._beta * stiffness, v)

    def _slopes(self, loads: Loads, loaded: LoadsAtShape) -> tuple[Array, Array, Array]:
        return loads.slopes(loaded) if len(loads.places) else self._no_slopes

    def _turned(self, start: FloatingState, spin: Array) -> tuple[Array, Array]:
        """Rotation at the end, and the Jacobian of its last turn, for a spin there."""
        turn, jacobian = exponential((0.5 * self._h) * (start.spin + spin))
        return start.rotation @ turn, jacobian

    def _ended(
        self, start: FloatingState, half: Array, q: Array, spin: Array, loads: Loads
    ) -> FloatingState:
        """The state at the end, once q is known: its spin is that of the angular momentum."""
        h = self._h
        v = (2.0 / h) * (q - start.q) - start.v
        at = self.inertia.at(q)
        found = times(self.inertia.mass, v) + by(spin, at.coupling)
        spin, rotation, moment = self._spun(start, half, q, v, spin, at, loads)
        moment = times(rotation, moment)
        force = loads.resultant(self._mass)
        velocity = start.velocity + (0.5 * h / self._mass) * (start.force + force)
        return FloatingState(
            time=start.time + h,
            position=start.position + 0.5 * h * (start.velocity + velocity),
            rotation=rotation,
            velocity=velocity,
            spin=spin,
            q=q,
            v=v,
            angular=half + 0.5 * h * moment,
            momenta=times(self.inertia.mass, v) + by(spin, at.coupling),
            push=(2.0 / h) * (found - start.momenta) - start.push,
            force=force,
            moment=moment,
        )

    def _spun(
        self,
        start: FloatingState,
        half: Array,
        q: Array,
        v: Array,
        spin: Array,
        at: InertiaAtShape,
        loads: Loads,
    ) -> tuple[Array, Array, Array]:
        """Spin, rotation and the loads' moment that make up the angular momentum at the end."""
        h = self._h
        deforming, change = times(at.coupling, v), np.empty(spin.shape)
        for _ in range(_SPIN_ITERATIONS):
            rotation, jacobian = self._turned(start, spin)
            angular, loaded = self._carried(half, q, rotation, loads)
            rest = times(at.inertia, spin) + deforming - angular - 0.5 * h * loaded.moment
            reach = skew(angular) + 0.5 * h * self._slopes(loads, loaded)[2]
            slope = at.inertia - reach @ (0.5 * h * jacobian)
            solve(slope, rest, change)
            spin = spin - change
            turn = 0.5 * h * times(jacobian, change)
            if np.abs(turn).max() <= _SMALL_TURN:
                rotation = orthonormalised(rotation - rotation @ skew(turn))
                angular, loaded = self._carried(half, q, rotation, loads)
                right = angular + 0.5 * h * loaded.moment - deforming
                solve(at.inertia, right, change)
                return change, rotation, loaded.moment
        raise StepFailure("no angular velocity was found that keeps the angular momentum")

    def _carried(
        self, half: Array, q: Array, rotation: Array, loads: Loads
    ) -> tuple[Array, LoadsAtShape]:
        """Angular momentum from the first half of the step, and the loads, in the frame."""
        return times(transposed(rotation), half), loads.at(q, rotation)
