"""How a training gets on, and when it may be done."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

# Share of the points, the last ones, whose errors tell how the next ones fall.
_LATE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """State of a training after a point was added.

    Args:
        points: number of points.
        training: error at the training poses [-].
        held_out: error at the held-out poses [-].
        seconds: time spent on points so far [s].
        seconds_left: estimate of the time until the tolerance or the number of points that was
            asked for [s]; None where the errors do not fall.
    """

    points: int
    training: float
    held_out: float
    seconds: float
    seconds_left: float | None


type Observer = Callable[[Progress], None]


def seconds_left(
    errors: Sequence[float], seconds: Sequence[float], tolerance: float, most: int
) -> float | None:
    """Time until the tolerance or the largest number of points, if all goes on as it did lately.

    Errors fall about exponentially with the points, and a point takes as long as the last ones.

    Args:
        errors: after each step so far, from the first.
        seconds: at which each step was done.
        tolerance: error at which to stop.
        most: number of steps at which to stop.
    """
    count = len(errors)
    early = count - 1 - max(1, int(_LATE * count))
    if early < 0:
        return None
    steps = most - count
    with np.errstate(all="ignore"):
        rate = np.log(errors[early] / errors[-1]) / (count - 1 - early)
        more = np.log(errors[-1] / tolerance) / rate
    if np.isfinite(more) and more >= 0.0:
        steps = min(steps, int(np.ceil(more)))
    elif steps > count:  # far from both ends
        return None
    return max(0, steps) * (seconds[-1] - seconds[early]) / (count - 1 - early)
