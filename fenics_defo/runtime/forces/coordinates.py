"""Checks of the arrays that a force law is given."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_ROUND_OFF = 1e-10  # of the largest entry; products of thousands of terms stay far below it


def frozen_array(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return a read-only contiguous array of finite floats, not copied where it need not be.

    Raises:
        ValueError: another shape or type, or values that are not finite.
    """
    given = np.asarray(values)
    if given.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, got {given.shape}")
    if given.dtype.kind not in "biuf":
        raise ValueError(f"{name} must hold real numbers, got the type {given.dtype}")
    array: Array = np.ascontiguousarray(given, dtype=np.float64).view()
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds values that are not finite")
    array.flags.writeable = False
    return array


def symmetric_array(name: str, values: ArrayLike) -> Array:
    """Return a symmetric matrix (r, r) as `frozen_array`, exactly symmetric, r >= 1.

    Raises:
        ValueError: it is not square, empty, or not symmetric to round-off.
    """
    r = np.shape(values)[0] if np.ndim(values) == 2 else 0
    if r == 0:
        raise ValueError(f"{name} must have the shape (r, r), got {np.shape(values)}")
    given = frozen_array(name, values, (r, r))
    apart = np.abs(given - given.T).max()
    if not apart <= _ROUND_OFF * np.abs(given).max():
        raise ValueError(f"{name} must be symmetric, entries differ by {apart:.3g}")
    return given if apart == 0.0 else frozen_array(name, 0.5 * (given + given.T), (r, r))


def checked(q: ArrayLike, size: int) -> Array:
    """Return coordinates as floats (..., size).

    Raises:
        ValueError: another number of coordinates.
    """
    array: Array = np.asarray(q, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"q must have the shape (..., {size}), got {array.shape}")
    return array


def by_batches(
    q: Array, tail: tuple[int, ...], most: int, evaluate: Callable[[Array], Array]
) -> Array:
    """Return ``evaluate`` of ``q`` (..., r) in batches of at most ``most`` bodies.

    Args:
        q: coordinates.
        tail: shape of the answer of one body.
        most: bodies in one batch, which bounds the memory of the buffers.
        evaluate: function of (b, r) whose answer (b, *tail) is copied before the next call.
    """
    bodies = q.reshape(-1, q.shape[-1])
    answer = np.empty((len(bodies), *tail))
    for begin in range(0, len(bodies), most):
        answer[begin : begin + most] = evaluate(bodies[begin : begin + most])
    return answer.reshape(*q.shape[:-1], *tail)
