"""A body's motion at one time over this rank's own nodes, and how it depends on what is unknown."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class StepFailure(Exception):
    """A step was not done; raised on all ranks alike.

    Args:
        reason: a clause that says why.
        residuals: relative residuals of Newton's iterations.
        lasting: whether a shorter step would fail in the same way.
    """

    def __init__(
        self, reason: str, residuals: tuple[float, ...] = (), *, lasting: bool = False
    ) -> None:
        super().__init__(reason)
        self.reason = reason
        self.residuals = residuals
        self.lasting = lasting


@dataclass(frozen=True, slots=True)
class Instant:
    """Motion at one time; the arrays are not written to once they are here.

    Args:
        time: [s].
        displacement: (owned nodes, 3) [m].
        velocity: (owned nodes, 3) [m/s].
        acceleration: (owned nodes, 3) [m/s²].
    """

    time: float
    displacement: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class Rule:
    """An implicit method's acceleration and velocity at the end of a step.

    a' = acceleration + acceleration_rate (u' - u),  v' = velocity + velocity_rate (u' - u), with u
    at the start of the step.

    Args:
        acceleration_rate: [1/s²].
        velocity_rate: [1/s].
        acceleration: (owned nodes, 3) [m/s²].
        velocity: (owned nodes, 3) [m/s].
        velocity_part: c if ``velocity`` is c times the velocity at the start, which spares a
            product with the damping; None if it is not.
    """

    acceleration_rate: float
    velocity_rate: float
    acceleration: Array
    velocity: Array
    velocity_part: float | None = None


@dataclass(frozen=True, slots=True)
class Forces:
    """Forces at an instant.

    Args:
        internal: f(u) (owned nodes, 3) [N].
        external: g(t, u) (owned nodes, 3) [N].
        damping: C v (owned nodes, 3) [N].
        reaction: of what prescribes motions, upon the body (owned nodes, 3) [N]; zero elsewhere.
    """

    internal: Array
    external: Array
    damping: Array
    reaction: Array
