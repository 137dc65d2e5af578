"""Where to look at a body from, so that it fills a picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_COMPACT = 2.0  # ratio of radii of gyration below which no principal axis stands out
_ALIGNED = 0.05  # share of the second moments off the diagonal that still counts as aligned
_SLENDER = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A parallel projection; lengths in the unit of the points it was chosen for.

    Args:
        right: unit vector to the right of the picture (3,).
        up: unit vector to its top (3,).
        towards: unit vector from the body to the eye (3,).
        centre: point in the middle of the picture (3,).
        width: extent of what is to be seen.
        height: likewise.
    """

    right: Array
    up: Array
    towards: Array
    centre: Array
    width: float
    height: float


def good_view(points: Array, moved: Array) -> View:
    """Choose a view of a body and all its motions from its principal axes.

    The eye stands off the long axis, above the ground plane, and sees three sides. A body that
    lies along the coordinate axes, or has no clear axis of its own, stands upright as in its
    coordinates (z up); any other lies on its broadest side.

    Args:
        points: nodes at rest (n, 3).
        moved: everything that has to be in the picture (..., 3).
    """
    long, wide, up, depth = _stance(points)
    slenderness = depth[0] / max(depth[1], 1e-12 * depth[0])
    # Shares of the direction to the eye: a slender body is seen more from the side.
    towards = (0.30 if slenderness > _SLENDER else 0.45) * long - 0.75 * wide + 0.48 * up
    towards /= np.linalg.norm(towards)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    above = np.cross(towards, right)
    flat = np.concatenate([moved.reshape(-1, 3), points])
    seen = np.stack([flat @ axis for axis in (right, above, towards)])
    low, high = seen.min(axis=1), seen.max(axis=1)
    middle = (low + high) / 2.0
    return View(
        right=right,
        up=above,
        towards=towards,
        centre=middle[0] * right + middle[1] * above + middle[2] * towards,
        width=high[0] - low[0],
        height=high[1] - low[1],
    )


def _stance(points: Array) -> tuple[Array, Array, Array, Array]:
    """Return the horizontal axis, the one into the picture, the vertical one, and extents.

    The extents are those of the horizontal axis and of the next longest.
    """
    offset = points - points.mean(axis=0)
    second = offset.T @ offset / len(points)
    moments, vectors = np.linalg.eigh(second)
    off_diagonal = np.linalg.norm(second - np.diag(np.diag(second)))
    compact = moments[2] <= _COMPACT**2 * moments[0]
    unit = np.eye(3)
    if compact or off_diagonal <= _ALIGNED * np.linalg.norm(second):
        spread = np.sqrt(np.diag(second))
        if spread[0] >= spread[1]:
            return unit[0], unit[1], unit[2], np.array([spread[0], max(spread[1:])])
        return unit[1], -unit[0], unit[2], np.array([spread[1], max(spread[0], spread[2])])
    up, long = vectors[:, 0], vectors[:, 2]
    up = up if up[2] >= 0.0 else -up
    long = long if long[np.argmax(np.abs(long))] >= 0.0 else -long
    return long, np.cross(up, long), up, np.sqrt(moments[[2, 1]])
