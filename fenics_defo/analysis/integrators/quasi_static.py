"""Equilibria one after the other, as slow loads pass through them."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_defo.analysis.instant import Instant, Rule

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


@dataclass(frozen=True, slots=True)
class QuasiStatic:
    """f(u') = g(t', u') without inertia or damping; velocities and accelerations are zero.

    Time only tells the histories of the loads how far they are. Use it with ``newton=None``.
    """

    @property
    def explicit(self) -> bool:
        """No."""
        return False

    @property
    def end_weight(self) -> float:
        """Trapezoids."""
        return 0.5

    @property
    def keeps_energy(self) -> bool:
        """No."""
        return False

    @property
    def hidden_energy(self) -> float:
        """None."""
        return 0.0

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Infinite."""
        return math.inf

    def advance(self, system: "System", start: Instant, step: float) -> Instant:
        """The equilibrium under the loads ``step`` [s] after ``start``; collective."""
        nothing = np.zeros_like(start.velocity)
        rule = Rule(
            acceleration_rate=0.0,
            velocity_rate=0.0,
            acceleration=nothing,
            velocity=nothing,
            velocity_part=0.0,
        )
        return system.solve(start, step, rule)
