"""How large a step explicit methods stand."""

import math


def leapfrog_limit(omega: float, beta: float) -> float:
    """Largest stable step [s] of leapfrog with a stiffness damping that lags by half a step.

    h = 2/ω (√(1 + ξ²) - ξ) with ξ = beta ω / 2: where a root of
    z² - (2 - h² ω² - h beta ω²) z + 1 - h beta ω² = 0 reaches -1.

    Args:
        omega: largest angular frequency [rad/s].
        beta: stiffness damping [s].
    """
    if not omega > 0.0:
        return math.inf
    ratio = 0.5 * beta * omega
    # The difference of the root and the ratio, written so that it does not cancel.
    return 2.0 / omega / (math.sqrt(1.0 + ratio**2) + ratio)
