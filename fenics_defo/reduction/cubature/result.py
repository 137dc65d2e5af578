"""What a training of a cubature gives."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.reduction.cubature.selection import Curve
from fenics_defo.runtime.forces import CubatureForce

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CubatureTraining:
    """A trained cubature and all that is known of its error.

    Args:
        force: the law.
        curve: errors as points were added.
        tolerance: error at the training poses that was asked for [-].
        poses: coordinates of the training poses (t, r).
        strains: largest strain ‖Fᵀ F − I‖ / 2 of each training pose (t,) [-].
        kind: "statics", "sampled" or "given".
        redrawn: poses drawn again because a cell was inside out.
        seed: of all that is random.
        candidates: number of points to choose from.
        rest_error: largest relative error of a frequency at rest within the basis, before any
            correction [-].
        seconds: by phase.
        training_error: root mean square of ‖f̂ − f‖ / ‖f‖ over the training poses [-].
        held_out_error: the same over poses that the weights were not fitted to [-].
        method: "thinned", "greedy" or "ecsw".
        advice: what to do where the tolerance was not reached, or the held-out error is above
            twice the tolerance; None where all is well.
    """

    force: CubatureForce
    curve: Curve
    tolerance: float
    poses: Array
    strains: Array
    kind: str
    redrawn: int
    seed: int
    candidates: int
    rest_error: float
    seconds: dict[str, float]
    training_error: float
    held_out_error: float
    method: str
    advice: str | None

    @property
    def points(self) -> int:
        """Number of points."""
        return self.force.points

    def certificate(self) -> dict[str, Any]:
        """What a model says of its cubature, in plain values."""
        return {
            "points": self.points,
            "candidates": self.candidates,
            "tolerance": self.tolerance,
            "training_error": self.training_error,
            "held_out_error": self.held_out_error,
            "poses": len(self.poses),
            "pose_kind": self.kind,
            "redrawn": self.redrawn,
            "largest_strain": float(self.strains.max()),
            "largest_point_strain": float(self.force.strains(self.poses).max()),
            "largest_coordinates": np.abs(self.poses).max(axis=0).tolist(),
            "rest_frequency_error": self.rest_error,
            "keeps_rest_stiffness": self.force.correction is not None,
            "method": self.method,
            "seed": self.seed,
            "advice": self.advice,
        }
