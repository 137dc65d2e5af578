"""Coordinates that a force law is given, and batches of them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def checked(q: ArrayLike, size: int) -> Array:
    """Return coordinates as floats (..., size).

    Raises:
        ValueError: another number of coordinates, or values that are not finite.
    """
    array: Array = np.asarray(q, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"q must have the shape (..., {size}), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("q holds values that are not finite")
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
