"""Whether a motion stays within what a model's cubature was trained for."""

import warnings
from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.runtime.forces import CubatureForce
from fenics_defo.runtime.model import ReducedModel

Array = NDArray[np.float64]

type Beyond = Literal["ignore", "warn", "raise"]


class OutOfRangeWarning(UserWarning):
    """A motion has left what its model was trained for."""


class OutOfRangeError(DefoError, ValueError):
    """A motion has left what its model was trained for."""


class RangeWatch:
    """Compares the strains at a model's cubature points with those of its training.

    A cubature is as good as its certificate tells within the strains of its training poses; beyond
    them its error is not known. A check costs about as much as a force:

        watch = runtime.RangeWatch(model, beyond="warn")
        for _ in range(steps):
            motion.advance(load)
            watch.check(motion.q)

    Args:
        model: one whose force is a cubature, with the certificate that `reduce` gave it.
        beyond: what to do beyond the range: "ignore", "warn" the first time, or "raise".
        margin: strain that is accepted, over the trained one [-].

    Raises:
        DefoError: another force or certificate, or arguments out of their range.
    """

    def __init__(
        self, model: ReducedModel, *, beyond: Beyond = "warn", margin: float = 1.0
    ) -> None:
        if beyond not in get_args(Beyond.__value__):
            raise DefoError(f"beyond must be 'ignore', 'warn' or 'raise', got {beyond!r}")
        if not 0.0 < margin < np.inf:
            raise DefoError(f"margin must be positive, a ratio of strains such as 1: {margin!r}")
        if not isinstance(model.law, CubatureForce):
            raise DefoError(
                f"a force of kind {model.law.kind!r} has no trained range to watch; watch models "
                "that were reduced with the force 'cubature'"
            )
        self._law, self._beyond, self._margin = model.law, beyond, margin
        #: Largest strain ‖Fᵀ F − I‖ / 2 at the points in training [-].
        self.trained: float = _trained_strain(model)
        #: Largest ratio of a strain to the trained one that a check has seen [-].
        self.largest: float = 0.0

    def check(self, q: ArrayLike) -> float:
        """Return the largest strain at ``q`` (..., r) over the trained one.

        Raises:
            OutOfRangeError: it is above the margin, where that is to be raised.
            ValueError: coordinates of another shape, or not finite.
        """
        ratio = float(self._law.strains(np.asarray(q, np.float64)).max()) / self.trained
        first = self.largest <= self._margin
        self.largest = max(self.largest, ratio)
        if ratio <= self._margin or self._beyond == "ignore":
            return ratio
        message = (
            f"the strain at the cubature's points is {ratio * self.trained:.3g}, {ratio:.3g} times "
            f"the largest in training: the force is a guess there; train to a larger strain, or "
            "with poses of this motion"
        )
        if self._beyond == "raise":
            raise OutOfRangeError(message)
        if first:
            warnings.warn(message, OutOfRangeWarning, stacklevel=2)
        return ratio


def _trained_strain(model: ReducedModel) -> float:
    told = model.certificate.get("force")
    strain = told.get("largest_point_strain") if isinstance(told, Mapping) else None
    if not isinstance(strain, float) or not 0.0 < strain < np.inf:
        raise DefoError(
            "this model's certificate does not tell the strains of its training; reduce the body "
            "again, with a training"
        )
    return strain
