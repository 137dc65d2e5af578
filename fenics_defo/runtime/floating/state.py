"""Where a floating body is, how it moves, and what it carries on to the next step."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FloatingState:
    """State at one time; leading axes are those of a batch.

    Args:
        time: [s].
        position: of the centre of mass (..., 3) [m].
        rotation: from the frame's axes to the world's (..., 3, 3).
        velocity: of the centre of mass (..., 3) [m/s].
        spin: angular velocity in the frame's axes (..., 3) [rad/s].
        q: coordinates of the deformation (..., r).
        v: their rates (..., r).
        angular: angular momentum about the centre of mass, world (..., 3) [kg m²/s].
        momenta: of q, M q' + A^T w (..., r).
        push: rate of change of the momenta (..., r), as the trapezoidal rule knows it.
        force: sum of the loads' forces, world (..., 3) [N].
        moment: moment of the loads about the centre of mass, world (..., 3) [N m].
    """

    time: float
    position: Array
    rotation: Array
    velocity: Array
    spin: Array
    q: Array
    v: Array
    angular: Array
    momenta: Array
    push: Array
    force: Array
    moment: Array

    def is_finite(self) -> bool:
        """Whether all of it is numbers."""
        # One sum is no number as soon as one of them is none; cheaper than to look at each.
        fields = (self.position, self.velocity, self.spin, self.q, self.v, self.push)
        return math.isfinite(sum(float(field.sum()) for field in fields))
