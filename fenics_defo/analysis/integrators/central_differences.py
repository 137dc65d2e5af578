"""Central differences with a lumped mass."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fenics_defo.analysis.instant import Instant
from fenics_defo.runtime.integrators.limits import leapfrog_limit

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


@dataclass(frozen=True, slots=True)
class CentralDifferences:
    """w = v + h/2 a,  u' = u + h w,  M a' = g' - f' - C w,  v' = w + h/2 a'.

    Explicit, of second order (of first in the stiffness part of the damping, which takes the
    velocity w from half a step earlier); stable below 2/ω (√(1 + ξ²) - ξ) with ξ = beta ω / 2.

    References: Belytschko, Liu and Moran, Nonlinear Finite Elements (2000), section 6.2.
    """

    @property
    def explicit(self) -> bool:
        """Yes."""
        return True

    @property
    def end_weight(self) -> float:
        """Trapezoids."""
        return 0.5

    @property
    def keeps_energy(self) -> bool:
        """Yes."""
        return True

    @property
    def hidden_energy(self) -> float:
        """None that is positive: ½ vᵀ M v falls short by h²/8 aᵀ M a."""
        return 0.0

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Largest stable step [s] at ``omega`` [rad/s]."""
        return leapfrog_limit(omega, damping[1])

    def advance(self, system: "System", start: Instant, step: float) -> Instant:
        """The motion ``step`` [s] after ``start``; collective."""
        time = start.time + step
        half = (0.5 * step) * start.acceleration
        half += start.velocity
        u = step * half
        u += start.displacement
        u = system.with_prescribed(time, u)
        # The mass part of the damping takes the velocity at the end itself: it stays of second
        # order and does not lower the limit.
        a = system.explicit_acceleration(time, u, half, lag=0.5 * step)
        v = (0.5 * step) * a
        v += half
        return system.instant(time, step, u, v, a)
