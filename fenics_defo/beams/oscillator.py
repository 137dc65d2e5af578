"""One mode of vibration with Rayleigh damping: period, decay and free motion."""

from dataclasses import dataclass
from math import expm1, inf, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.beams.checks import BeamError, require_finite, require_positive

type Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DampedOscillator:
    """Free motion of q'' + 2 zeta omega q' + omega^2 q = 0.

    Args:
        omega: undamped circular frequency [rad/s].
        ratio: zeta, the fraction of critical damping [-]; below 1 the motion oscillates.
    """

    omega: float
    ratio: float

    @property
    def decay_rate(self) -> float:
        """Zeta omega [1/s]: the envelope of an oscillation is exp(-zeta omega t)."""
        return self.ratio * self.omega

    @property
    def period(self) -> float:
        """2 pi / (omega sqrt(1 - zeta^2)) [s]; infinite at and above critical damping."""
        rest = (1.0 - self.ratio) * (1.0 + self.ratio)
        return 2.0 * pi / (self.omega * sqrt(rest)) if rest > 0.0 else inf

    @property
    def logarithmic_decrement(self) -> float:
        """Logarithm of the ratio of successive maxima [-]; infinite if there are none."""
        return self.decay_rate * self.period

    def decay_over(self, time: float) -> float:
        """Fraction of the envelope lost in ``time`` [s]: 1 - exp(-zeta omega t)."""
        return -expm1(-self.decay_rate * require_finite("time", time, unit="s"))

    def free_motion(self, times: ArrayLike, *, start: float, velocity: float = 0.0) -> Array:
        """q(t) from q(0) = ``start`` and q'(0) = ``velocity``, at ``times`` [s], of their shape.

        q = exp(-zeta omega t) (start c(t) + (velocity + zeta omega start) s(t)), with c and s the
        cosine and sine of omega_d t over 1 and omega_d, hyperbolic above critical damping and 1
        and t at it. Written with complex exponentials none of which grows.
        """
        t = np.asarray(times, dtype=np.float64)
        spread = self.omega * np.sqrt(complex(self.ratio**2 - 1.0))
        slow, fast = np.exp((spread - self.decay_rate) * t), np.exp(-(spread + self.decay_rate) * t)
        push = velocity + self.decay_rate * start
        if abs(spread) < 1e-7 * self.omega:
            return np.asarray((start + push * t) * np.exp(-self.decay_rate * t))
        return np.asarray((0.5 * start * (slow + fast) + 0.5 * push * (slow - fast) / spread).real)


def rayleigh_oscillator(
    *, frequency: float, mass_damping: float = 0.0, stiffness_damping: float = 0.0
) -> DampedOscillator:
    """The oscillator that a mode of a body with C = alpha M + beta K is.

    zeta = alpha / (2 omega) + beta omega / 2.

    Args:
        frequency: undamped frequency [Hz].
        mass_damping: alpha [1/s], not negative.
        stiffness_damping: beta [s], not negative.

    Raises:
        BeamError: the frequency is not positive, or a coefficient is negative or not finite.

    References:
        Clough and Penzien, Dynamics of Structures, chapter 12 (Rayleigh damping) and chapter 3
        (damped free vibration).
    """
    omega = 2.0 * pi * require_positive("frequency", frequency, unit="Hz")
    for name, value, unit in (
        ("mass_damping", mass_damping, "1/s"),
        ("stiffness_damping", stiffness_damping, "s"),
    ):
        if not require_finite(name, value, unit=unit) >= 0.0:
            raise BeamError(f"{name} must not be negative [{unit}], got {value!r}; give 0 for none")
    return DampedOscillator(omega, 0.5 * (mass_damping / omega + stiffness_damping * omega))
