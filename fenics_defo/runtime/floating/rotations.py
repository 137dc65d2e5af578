"""Rotations as matrices: exponential map, its derivative, quaternions; any leading axes."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.products import times, transposed

Array = NDArray[np.float64]

# A vector times this (3, 9) is the matrix of the cross product with it.
_LEVI_CIVITA = np.zeros((3, 3, 3))
for _k, _i, _j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _LEVI_CIVITA[_k, _i, _j], _LEVI_CIVITA[_k, _j, _i] = 1.0, -1.0
_TO_SKEW = -_LEVI_CIVITA.reshape(3, 9)
LEVI_CIVITA = _LEVI_CIVITA.reshape(3, 9)
"""e_kab as (3, 9): a product with moments (9, ...) of two vectors gives their cross product's."""
_EYE = np.eye(3)
_THREE_HALVES = 1.5 * _EYE

# Below this square of an angle the series are exact to round-off.
_SMALL = 1e-4


def skew(vector: Array) -> Array:
    """Matrices (..., 3, 3) of the cross products a x b with vectors a (..., 3)."""
    return (vector @ _TO_SKEW).reshape(*vector.shape, 3)


def cross(left: Array, right: Array) -> Array:
    """Cross products (..., 3); for few vectors several times faster than NumPy's."""
    return times(skew(left), right)


def exponential(angle: Array) -> tuple[Array, Array]:
    """Rotations by rotation vectors, and the right Jacobians of the map.

        exp = 1 + a S + b S²,  J = 1 - b S + c S²,  S = skew(angle), t = |angle|,
        a = sin t / t,  b = (1 - cos t) / t²,  c = (1 - a) / t²

    so that exp(angle + d) = exp(angle) exp(J d) to first order in d: Rodrigues' formula, and the
    derivative of the exponential (Hairer, Lubich and Wanner, Geometric Numerical Integration,
    section III.4) summed up for skew matrices.

    Args:
        angle: (..., 3) [rad].

    Returns:
        both (..., 3, 3).
    """
    s = skew(angle)
    twice = s @ s
    a: Any
    b: Any
    c: Any
    if angle.ndim == 1:  # numbers are several times faster than arrays of one number
        square = float(angle @ angle)
        a, b, c = _of_small(square) if square < _SMALL else _of_one(square)
    else:
        squares = (angle * angle).sum(axis=-1)[..., None, None]
        a, b, c = _of_many(squares)
    return _EYE + a * s + b * twice, _EYE - b * s + c * twice


def _of_small[T: (float, Array)](square: T) -> tuple[T, T, T]:
    """Series of a, b and c of `exponential` in the square of the angle."""
    return (
        1.0 - square / 6.0 * (1.0 - square / 20.0),
        0.5 - square / 24.0 * (1.0 - square / 30.0),
        1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0),
    )


def _of_one(square: float) -> tuple[float, float, float]:
    t = math.sqrt(square)
    a, half = math.sin(t) / t, math.sin(0.5 * t) / t
    return a, 2.0 * half * half, (1.0 - a) / square  # without the cancellation of 1 - cos


def _of_many(squares: Array) -> tuple[Array, Array, Array]:
    small = squares < _SMALL
    safe = np.where(small, 1.0, squares)
    t = np.sqrt(safe)
    a, half = np.sin(t) / t, np.sin(0.5 * t) / t
    large = (a, 2.0 * half * half, (1.0 - a) / safe)
    found = [np.where(small, x, y) for x, y in zip(_of_small(squares), large, strict=True)]
    return found[0], found[1], found[2]


def orthonormalised(rotation: Array) -> Array:
    """The rotations (..., 3, 3) with round-off taken out: one step of R (3 - R^T R) / 2."""
    return rotation @ (_THREE_HALVES - 0.5 * (transposed(rotation) @ rotation))


def from_quaternion(quaternion: Array) -> Array:
    """Rotations (..., 3, 3) of unit quaternions (..., 4), the scalar first."""
    w, v = quaternion[..., :1, None], quaternion[..., 1:]
    s = skew(v)
    return np.asarray(_EYE + 2.0 * (w * s + s @ s))


def to_quaternion(rotation: Array) -> Array:
    """Unit quaternions (..., 4), the scalar first and not negative, of rotations (..., 3, 3).

    The column with the greatest diagonal entry of 4 p p^T, which is linear in the matrix: accurate
    for all rotations (Shepperd, Journal of Guidance and Control 1, 1978).
    """
    r = rotation
    table = np.empty((*r.shape[:-2], 4, 4))
    trace = np.trace(r, axis1=-2, axis2=-1)
    table[..., 0, 0] = 1.0 + trace
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[..., 0, k + 1] = table[..., k + 1, 0] = r[..., j, i] - r[..., i, j]
        table[..., k + 1, k + 1] = 1.0 - trace + 2.0 * r[..., k, k]
        table[..., i + 1, j + 1] = table[..., j + 1, i + 1] = r[..., i, j] + r[..., j, i]
    best = np.argmax(np.diagonal(table, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(table, best[..., None, None], axis=-1)[..., 0]
    column = np.where(column[..., :1] < 0.0, -column, column)
    return np.asarray(column / np.linalg.norm(column, axis=-1, keepdims=True))
