"""Order in a computed spectrum: clusters, signs, fields that a mode's motion is compared with."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A field claims a vector if this part of the best seen field's projection is left for it. Below
# 1/sqrt(k) of clusters of any real size, so that unit vectors always complete the claims.
_CLAIM = 1e-3
# Projections of unit fields below this are round-off.
_UNSEEN = 1e-8


def cluster_end(values: Array, count: int, *, rtol: float) -> int:
    """Smallest end at or past ``count`` that does not cut a cluster of equal eigenvalues.

    Args:
        values: ascending λ [rad²/s²], more than ``count`` unless there are no more.
        count: number of values wanted.
        rtol: largest relative distance of neighbours in a cluster.

    Returns:
        number of values to keep; ``len(values)`` when the last cluster may go on.
    """
    end = count
    while end < len(values) and values[end] - values[end - 1] <= rtol * abs(values[end]):
        end += 1
    return end


def align_clusters(values: Array, projections: Array, *, rtol: Array) -> Array:
    """Rotation that makes vectors of equal eigenvalues unique: each takes all of one field's share.

    Within a cluster any rotation solves the eigenvalue problem. Taken is the one in which the first
    vector holds all of the first field that the cluster projects on (x, then y, ...), the second
    none of it, and so on.

    Args:
        values: (k,) ascending λ.
        projections: (k, p) ⟨vector, field⟩ of fields of norm 1, in the order of their claim.
        rtol: (k,) largest relative distance of an eigenvalue from the one before it in a cluster.

    Returns:
        (k, k) orthogonal and block diagonal; multiply the vectors by it from the right.
    """
    rotation = np.eye(len(values))
    joined = np.diff(values) <= rtol[1:] * np.abs(values[1:])
    bounds = np.flatnonzero(np.concatenate([[True], ~joined, [True]]))
    for start, end in pairwise(bounds):
        if end - start > 1:
            here = slice(start, end)
            rotation[here, here] = _claimed(projections[here])
    return rotation


def _claimed(projections: Array) -> Array:
    """Orthogonal (k, k): of each field's projection the part that earlier ones have not taken."""
    size = len(projections)
    scale = np.linalg.norm(projections, axis=0).max(initial=0.0)
    if not scale > _UNSEEN:
        return np.eye(size)
    columns = np.zeros((size, 0))
    # Unit vectors complete what no field sees.
    for field in (*(projections.T / scale), *np.eye(size)):
        rest = field - columns @ (columns.T @ field)
        rest -= columns @ (columns.T @ rest)
        length = np.linalg.norm(rest)
        if length > _CLAIM:
            columns = np.column_stack([columns, rest / length])
        if columns.shape[1] == size:
            return columns
    raise AssertionError("unit vectors span the space")


def signs(shapes: Array) -> Array:
    """Signs (k,) that make the largest component of each shape positive.

    Args:
        shapes: (k, n, 3). Of components that are equally large, the first decides.
    """
    flat = shapes.reshape(len(shapes), -1)
    size = np.abs(flat)
    first = np.argmax(size >= (1.0 - 1e-6) * size.max(axis=1, keepdims=True), axis=1)
    return np.where(flat[np.arange(len(flat)), first] < 0.0, -1.0, 1.0)


def quadratic_fields(points: Array) -> Array:
    """Displacement fields whose components are polynomials of degree 0 to 2 in the coordinates.

    Args:
        points: (d, 3), centred and scaled to order one.

    Returns:
        (30, d, 3): x, y, z, the three rotations, then the rest, of the second degree last.
    """
    one = np.ones(len(points))
    x, y, z = points.T
    fields = np.zeros((30, len(points), 3))
    fields[range(3), :, range(3)] = one
    for axis, (first, second) in enumerate(((1, 2), (2, 0), (0, 1))):
        fields[3 + axis, :, second] = points[:, first]
        fields[3 + axis, :, first] = -points[:, second]
    # Of each pair of shears one gives way to the rotation.
    strains = [(x, (0, 2)), (y, (0, 1)), (z, (1, 2))]
    quadrics = [(scalar, (0, 1, 2)) for scalar in (x * x, y * y, z * z, x * y, y * z, z * x)]
    place = 6
    for scalar, axes in (*strains, *quadrics):
        for axis in axes:
            fields[place, :, axis] = scalar
            place += 1
    return fields
