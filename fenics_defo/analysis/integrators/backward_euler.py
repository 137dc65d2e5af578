"""Euler's implicit method."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_defo.analysis.instant import Instant, Rule

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


@dataclass(frozen=True, slots=True)
class BackwardEuler:
    """u' = u + h v',  v' = v + h a',  M a' + C v' + f' = g'.

    Of first order; stable for any step on linear bodies, and damps what it does not resolve.

    References: Baraff and Witkin, Large steps in cloth simulation, SIGGRAPH 1998.
    """

    @property
    def explicit(self) -> bool:
        """No."""
        return False

    @property
    def end_weight(self) -> float:
        """Forces at the end of the step: what then lacks in the balance is the method's damping."""
        return 1.0

    @property
    def keeps_energy(self) -> bool:
        """No."""
        return False

    @property
    def hidden_energy(self) -> float:
        """None: it takes energy."""
        return 0.0

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Infinite."""
        return math.inf

    def advance(self, system: "System", start: Instant, step: float) -> Instant:
        """The motion ``step`` [s] after ``start``; collective."""
        return system.solve(
            start,
            step,
            Rule(
                acceleration_rate=1.0 / step**2,
                velocity_rate=1.0 / step,
                acceleration=start.velocity * (-1.0 / step),
                velocity=np.zeros_like(start.velocity),
                velocity_part=0.0,
            ),
        )
