"""One step of a floating body: the trapezoidal rule in its momenta."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.inertia import Inertia, InertiaAtShape
from fenics_defo.runtime.floating.loads import Loads, LoadsAtShape
from fenics_defo.runtime.floating.rotations import exponential, orthonormalised, skew
from fenics_defo.runtime.floating.state import FloatingState

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


@dataclass(frozen=True, slots=True, eq=False)
class _Linearised:
    """Equations of the end of a step about an iterate: residuals and their derivatives.

    Args:
        shape: residual of q (..., r).
        spin: residual of the angular momentum (..., 3).
        shape_by_q: (..., r, r).
        shape_by_spin: (..., r, 3).
        spin_by_q: (..., 3, r).
        spin_by_spin: (..., 3, 3).
        terms: what the two residuals are sums of.
    """

    shape: Array
    spin: Array
    shape_by_q: Array
    shape_by_spin: Array
    spin_by_q: Array
    spin_by_spin: Array
    terms: tuple[tuple[Array, ...], tuple[Array, ...]]

    def excess(self) -> float:
        """Largest residual relative to the largest term [-]."""
        return max(_excess(self.shape, self.terms[0]), _excess(self.spin, self.terms[1]))


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
        law: elastic force of q: a force law.
        inertia: of the body.
        mass: of the body [kg].
        damping: (alpha [1/s], beta [s]); C = alpha M + beta K(q) acts on the rates of q.
        step: h [s].
        newton: how Newton's method ends.
        shape: shape of q, (r,) or (b, r).
    """

    def __init__(
        self,
        law: Any,
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
        self._heavy = (4.0 / step**2 + 2.0 / step * damping[0]) * inertia.mass
        self._stiff = 1.0 + 2.0 / step * damping[1]

    def begun(self, state: FloatingState, loads: Loads) -> FloatingState:
        """A state with the rates that its loads, acting from now, give it."""
        at = self.inertia.at(state.q)
        push, moment = self._push(state.q, state.v, state.spin, at, state.rotation, loads)
        return replace(
            state,
            push=push,
            moment=_times(state.rotation, moment),
            force=loads.resultant(self._mass),
        )

    def _push(
        self,
        q: Array,
        v: Array,
        spin: Array,
        at: InertiaAtShape,
        rotation: Array,
        loads: Loads,
    ) -> tuple[Array, Array]:
        """Rate of the momenta of q, and the loads' moment in the frame."""
        force, stiffness = self._evaluator.force_and_stiffness(q)
        loaded = loads.at(q, rotation)
        rows = self.inertia.gyroscopic_rows(v) + 0.5 * at.inertia_slope(spin)
        damping = _times(self._alpha * self.inertia.mass + self._beta * stiffness, v)
        return _by(spin, rows) - force - damping + loaded.push, loaded.moment

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
            change, turn = _solved(now)
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
    ) -> _Linearised:
        """The equations about q and spin, with the elastic force linear about ``bent``."""
        h, inertia = self._h, self.inertia
        v = (2.0 / h) * (q - start.q) - start.v
        at = inertia.at(q)
        rows, slope = inertia.gyroscopic_rows(v), at.inertia_slope(spin)
        gyro, softening = inertia.turning(spin)
        force, stiffness = self._evaluator.force_and_stiffness(bent)
        rotation, jacobian = self._turned(start, spin)
        angular = _times(np.swapaxes(rotation, -1, -2), half)
        loaded = loads.at(q, rotation)
        momenta = _times(inertia.mass, v) + _by(spin, at.coupling)
        elastic = force if bent is q else force + _times(stiffness, q - bent)
        damping = _times(self._alpha * inertia.mass + self._beta * stiffness, v)
        inertial = (2.0 / h) * (momenta - start.momenta) - start.push
        shape = inertial - _by(spin, rows + 0.5 * slope) + elastic + damping - loaded.push
        carried, deforming = _times(at.inertia, spin), _times(at.coupling, v)
        turning = carried + deforming - angular - 0.5 * h * loaded.moment
        terms = (elastic, damping, loaded.push, start.push, (2.0 / h) * momenta)
        by_q = self._heavy + self._stiff * stiffness - (4.0 / h) * gyro - softening
        push_turn, moment_q, moment_turn = self._slopes(loads, loaded)
        reach = 0.5 * h * jacobian
        return _Linearised(
            shape,
            turning,
            by_q,
            np.swapaxes((2.0 / h) * at.coupling - rows - slope, -1, -2) - push_turn @ reach,
            slope + (2.0 / h) * at.coupling + rows - 0.5 * h * moment_q,
            at.inertia - (skew(angular) + 0.5 * h * moment_turn) @ reach,
            (terms, (carried, deforming, angular)),
        )

    def _slopes(self, loads: Loads, loaded: LoadsAtShape) -> tuple[Array, Array, Array]:
        if len(loads.places):
            return loads.slopes(loaded)
        r = len(self.inertia.mass)
        return np.zeros((r, 3)), np.zeros((3, r)), np.zeros((3, 3))

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
        found = _times(self.inertia.mass, v) + _by(spin, at.coupling)
        spin, rotation, moment = self._spun(start, half, q, v, spin, at, loads)
        moment = _times(rotation, moment)
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
            momenta=_times(self.inertia.mass, v) + _by(spin, at.coupling),
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
        deforming = _times(at.coupling, v)
        for _ in range(_SPIN_ITERATIONS):
            rotation, jacobian = self._turned(start, spin)
            angular, loaded = self._carried(half, q, rotation, loads)
            rest = _times(at.inertia, spin) + deforming - angular - 0.5 * h * loaded.moment
            reach = skew(angular) + 0.5 * h * self._slopes(loads, loaded)[2]
            slope = at.inertia - reach @ (0.5 * h * jacobian)
            change = np.linalg.solve(slope, rest[..., None])[..., 0]
            spin = spin - change
            turn = 0.5 * h * _times(jacobian, change)
            if np.abs(turn).max() <= _SMALL_TURN:
                rotation = orthonormalised(rotation - rotation @ skew(turn))
                angular, loaded = self._carried(half, q, rotation, loads)
                right = angular + 0.5 * h * loaded.moment - deforming
                spin = np.linalg.solve(at.inertia, right[..., None])[..., 0]
                return spin, rotation, loaded.moment
        raise StepFailure("no angular velocity was found that keeps the angular momentum")

    def _carried(
        self, half: Array, q: Array, rotation: Array, loads: Loads
    ) -> tuple[Array, LoadsAtShape]:
        """Angular momentum from the first half of the step, and the loads, in the frame."""
        return _times(np.swapaxes(rotation, -1, -2), half), loads.at(q, rotation)


def _solved(at: _Linearised) -> tuple[Array, Array]:
    """Changes of q and of the spin: elimination of q, then three equations."""
    right = np.concatenate([at.shape[..., None], at.shape_by_spin], axis=-1)
    answer = np.linalg.solve(at.shape_by_q, right)
    alone, along = answer[..., :1], answer[..., 1:]
    reduced = at.spin_by_spin - at.spin_by_q @ along
    turn = np.linalg.solve(reduced, at.spin_by_q @ alone - at.spin[..., None])
    return -(alone + along @ turn)[..., 0], turn[..., 0]


def _times(matrix: Array, vector: Array) -> Array:
    """Matrices (..., m, n) times vectors (..., n)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _by(vector: Array, rows: Array) -> Array:
    """Rows (..., 3, r) summed by the components of vectors (..., 3)."""
    return np.asarray((vector[..., None, :] @ rows)[..., 0, :])


def _excess(residual: Array, terms: tuple[Array, ...]) -> float:
    """Largest norm of a residual (..., k) relative to the largest of its terms."""
    size = np.sqrt((residual * residual).sum(axis=-1))
    scale = np.sqrt(np.max([(term * term).sum(axis=-1) for term in np.broadcast_arrays(*terms)], 0))
    ratio = np.divide(size, scale, out=np.array(size), where=scale > 0.0)
    return float(np.max(ratio))
