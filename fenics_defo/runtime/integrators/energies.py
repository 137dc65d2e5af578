"""Energies along a motion, for those who ask."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.scheme import Scheme

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies [J] of one body, or of each of b (b,).

    kinetic + strain - their values at the start = external - dissipated, but for the error of the
    integrator.

    Args:
        kinetic: ½ vᵀ M v.
        strain: of the force law.
        external: work of loads and impulses since the start.
        dissipated: ∫ vᵀ C v dt by Rayleigh damping since the start.
    """

    kinetic: float | Array
    strain: float | Array
    external: float | Array
    dissipated: float | Array

    @property
    def balance(self) -> float | Array:
        """Kinetic + strain + dissipated - external [J]: constant but for the method's error."""
        return self.kinetic + self.strain + self.dissipated - self.external


class Work:
    """Sums of force times displacement over steps.

    Over a step Δq the force is that at its end times w plus that at its start times 1 - w.

    Args:
        scheme: has the motion.
        inertia: its mass.
        damping: (alpha [1/s], beta [s]).
        end_weight: w.
        load: generalised force at the start.
        load_at_start: whether a step is given the load at its start, not that at its end. The part
            w of the load at its end is then added by the next step.
    """

    def __init__(
        self,
        scheme: Scheme,
        inertia: Inertia,
        damping: tuple[float, float],
        *,
        end_weight: float,
        load: Array,
        load_at_start: bool,
    ) -> None:
        self._scheme, self._inertia, self._damping = scheme, inertia, damping
        self._end_weight, self._load_at_start = end_weight, load_at_start
        bodies = load.shape[:-1]
        self._external, self._dissipated = np.zeros(bodies), np.zeros(bodies)
        self._load, self._pending = load.copy(), np.zeros_like(load)
        self._q, self._change = scheme.q.copy(), np.zeros_like(load)
        self._damped = any(damping)
        self._drag = self._damping_force()

    def add_step(self, load: Array) -> None:
        """Count a step that was done with a load."""
        w, q = self._end_weight, self._scheme.q
        np.subtract(q, self._q, self._change)
        if self._load_at_start:
            self._external += w * np.vecdot(self._pending, load)
            self._pending, self._change = self._change, self._pending
            change = self._pending
        else:
            change = self._change
            self._external += w * np.vecdot(change, load)
        self._external += (1.0 - w) * np.vecdot(change, load if self._load_at_start else self._load)
        if self._damped:
            drag = self._damping_force()
            part = w * np.vecdot(change, drag) + (1.0 - w) * np.vecdot(change, self._drag)
            self._dissipated += part
            self._drag = drag
        self._q[...] = q
        self._load[...] = load

    def add_blow(self, momentum: Array, before: Array, after: Array) -> None:
        """Count an impulse (..., r) by the velocities before and after it."""
        self._external += 0.5 * np.vecdot(momentum, before + after)
        self._drag = self._damping_force()

    @property
    def external(self) -> Array:
        """Work of loads and impulses (...) [J]."""
        ahead = self._end_weight * np.vecdot(self._pending, self._load)
        return np.asarray(self._external + ahead)

    @property
    def dissipated(self) -> Array:
        """Energy that damping took (...) [J]."""
        return self._dissipated

    def _damping_force(self) -> Array:
        """C v = alpha M v + beta K(q) v at the present state, as a new array."""
        (alpha, beta), scheme = self._damping, self._scheme
        v = scheme.v
        force = alpha * (v if self._inertia.is_identity else self._inertia.apply(v))
        if beta:
            force += beta * scheme.here.stiffness_times(scheme.q, v)
        return force


def plain(value: Array) -> float | Array:
    """A number for one body, a fresh array for several."""
    return float(value) if np.ndim(value) == 0 else np.array(value)
