"""Newmark's implicit method."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fenics_defo.analysis.instant import Instant, Rule
from fenics_defo.errors import LoadError

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


@dataclass(frozen=True, slots=True)
class ImplicitNewmark:
    """u' = u + h v + h² ((½ - β) a + β a'),  v' = v + h ((1 - γ) a + γ a'),  M a' + C v' + f' = g'.

    The default, average acceleration, is of second order, stable for any step on linear bodies, and
    keeps their energy exactly. γ > ½ damps the high frequencies and is of first order.

    Args:
        beta: β, positive [-].
        gamma: γ, at least ½ [-].

    Raises:
        LoadError: β or γ out of range, or 2 β < γ, where the method is not stable for any step.

    References: Newmark, J. Eng. Mech. Div. ASCE 85(3), 1959; Hughes, The Finite Element Method
    (2000), section 9.1.
    """

    beta: float = 0.25
    gamma: float = 0.5

    def __post_init__(self) -> None:
        if not (self.gamma >= 0.5 and 2.0 * self.beta >= self.gamma and self.beta < math.inf):
            raise LoadError(
                "ImplicitNewmark is stable for any step where gamma >= 0.5 and 2 beta >= gamma, "
                f"got beta = {self.beta!r} and gamma = {self.gamma!r}; the usual values are 0.25 "
                "and 0.5"
            )

    @property
    def explicit(self) -> bool:
        """No."""
        return False

    @property
    def end_weight(self) -> float:
        """Trapezoids: with average acceleration the energies of a linear body balance exactly."""
        return 0.5

    @property
    def keeps_energy(self) -> bool:
        """Where γ = ½."""
        return self.gamma == 0.5

    @property
    def hidden_energy(self) -> float:
        """β - γ/2: nothing for the average acceleration (Hughes 2000, section 9.4)."""
        return max(self.beta - 0.5 * self.gamma, 0.0)

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Infinite."""
        return math.inf

    def advance(self, system: "System", start: Instant, step: float) -> Instant:
        """The motion ``step`` [s] after ``start``; collective."""
        v, a = start.velocity, start.acceleration
        rate = 1.0 / (self.beta * step**2)
        ratio = self.gamma / self.beta
        # The accelerations cancel where gamma = 2 beta, as with average acceleration.
        part = 1.0 - ratio if self.gamma == 2.0 * self.beta else None
        rest = v * (-1.0 / (self.beta * step)) - a * (0.5 / self.beta - 1.0)
        return system.solve(
            start,
            step,
            Rule(
                acceleration_rate=rate,
                velocity_rate=self.gamma * step * rate,
                acceleration=rest,
                velocity=(1.0 - ratio) * v + (step * (1.0 - 0.5 * ratio)) * a,
                velocity_part=part,
            ),
        )
