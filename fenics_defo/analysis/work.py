"""Work of loads, supports and damping along a motion."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.instant import Forces, Instant

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


Array = NDArray[np.float64]


class Work:
    """Sums of force times displacement over steps; collective.

    Over a step Δu the force is that at its end times w plus that at its start times 1 - w. With
    w = ½ and Newmark's average acceleration, ΔT + ΔU = external - dissipated holds to round-off on
    linear bodies, for then M Δv · (v + v')/2 = Δu · (forces + forces')/2.

    Args:
        system: the equations.
        end_weight: w.
    """

    def __init__(self, system: "System", end_weight: float) -> None:
        self._system = system
        self._end_weight = end_weight
        #: Work of loads, impulses and prescribed motions [J].
        self.external = 0.0
        #: Energy that damping took [J].
        self.dissipated = 0.0
        #: Largest work of one step or blow so far [J].
        self.largest = 0.0

    def add_step(self, start: Instant, end: Instant, before: Forces, after: Forces) -> None:
        """Count a step that was done, with the forces at its start and its end."""
        system = self._system
        change = end.displacement - start.displacement
        work = self._along(change, before.external, after.external)
        if system.constraints.moving:
            work += self._along(change, before.reaction, after.reaction)
        self._count(work)
        if system.is_damped:
            self.dissipated += self._along(change, before.damping, after.damping)

    def _along(self, change: Array, before: Array, after: Array) -> float:
        w = self._end_weight
        own = w * float(np.vdot(change, after))
        if w < 1.0:
            own += (1.0 - w) * float(np.vdot(change, before))
        return float(self._system.comm.allreduce(own))

    def add_blow(self, momentum: Array, before: Array, after: Array) -> None:
        """Count an impulse (owned nodes, 3) [N s] by the velocities before and after it."""
        self._count(0.5 * self._system.product(momentum, before + after))

    def _count(self, work: float) -> None:
        self.external += work
        self.largest = max(self.largest, abs(work))
