"""Euler's symplectic method with a lumped mass."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fenics_defo.analysis.instant import Instant
from fenics_defo.runtime.integrators.limits import leapfrog_limit

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System


@dataclass(frozen=True, slots=True)
class SymplecticEuler:
    """v' = v + h M⁻¹ (g - f(u) - C v),  u' = u + h v'.

    Explicit, of first order; it walks through the same displacements as central differences with
    velocities half a step late, so that its energy oscillates by O(h) but does not drift. Stable
    below 2/ω (√(1 + ξ²) - ξ) with ξ = beta ω / 2.

    References: Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), section I.1.
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
        """None of this form."""
        return 0.0

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Largest stable step [s] at ``omega`` [rad/s]."""
        return leapfrog_limit(omega, damping[1])

    def advance(self, system: "System", start: Instant, step: float) -> Instant:
        """The motion ``step`` [s] after ``start``; collective."""
        time, u, v = start.time + step, start.displacement, start.velocity
        a = system.explicit_acceleration(start.time, u, v, lag=step)
        faster = step * a
        faster += v
        ahead = step * faster
        ahead += u
        return system.instant(time, step, system.with_prescribed(time, ahead), faster, a)
