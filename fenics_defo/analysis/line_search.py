"""How far to go along a direction of descent."""

from collections.abc import Callable

import numpy as np

_TRIALS = 14
# The slope along a search direction must fall to this part of what it was, to either side.
_FLAT = 0.7
# Farthest that a search goes, in directions.
_FARTHEST = 4.0


def flatter(slope: float, slope_at: Callable[[float], float]) -> float | None:
    """A length along a direction at which the slope is smaller than at its start.

    It begins at 1, Newton's own length. Where the slope is still steep there, the matrix was too
    stiff, and it goes on; where it has become steep uphill, it goes back by regula falsi.

    Args:
        slope: at 0; negative.
        slope_at: slope at a length; infinite or no number where the function is.

    Returns:
        the length; the longest that is downhill if none is flat; None if even the shortest tried
        leads steeply uphill.
    """
    low, low_slope, high, high_slope = 0.0, slope, np.inf, np.inf
    length = 1.0
    for _ in range(_TRIALS):
        here = slope_at(length)
        if abs(here) <= _FLAT * abs(slope):
            return length
        if here < 0.0:
            low, low_slope = length, here
        else:  # no number, too
            high, high_slope = length, here
        if np.isinf(high):
            length = 2.0 * low
            if length > _FARTHEST:
                break
            continue
        part = low_slope / (low_slope - high_slope) if np.isfinite(high_slope) else 0.5
        # Kept off both ends.
        length = low + (high - low) * min(max(part, 0.1), 0.6)
    return low if low > 0.0 else None
