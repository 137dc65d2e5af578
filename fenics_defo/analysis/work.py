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

    def add_step(self, start: Instant, end: Instant, before: Forces, after: Forces) -> None:
        """Count a step that was done, with the forces at its start and its end."""
        system, w = self._system, self._end_weight
        change = end.displacement - start.displacement
        outer = w * (after.external + after.reaction)
        outer += (1.0 - w) * (before.external + before.reaction)
        self.external += system.product(change, outer)
        viscous = w * after.damping + (1.0 - w) * before.damping
        self.dissipated += system.product(change, viscous)

    def add_blow(self, momentum: Array, before: Array, after: Array) -> None:
        """Count an impulse (owned nodes, 3) [N s] by the velocities before and after it."""
        self.external += 0.5 * self._system.product(momentum, before + after)
