"""Arrays of records: checked once, then read-only."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

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
    with np.errstate(over="ignore", invalid="ignore"):  # an infinite difference is refused as well
        apart = np.abs(given - given.T).max()
    if not apart <= _ROUND_OFF * np.abs(given).max():
        raise ValueError(f"{name} must be symmetric, entries differ by {apart:.3g}")
    return given if apart == 0.0 else frozen_array(name, given + 0.5 * (given.T - given), (r, r))


def frozen_integers(name: str, values: ArrayLike, shape: tuple[int, ...]) -> IntArray:
    """Return a read-only contiguous array of int64, not copied where it need not be.

    Raises:
        ValueError: another shape or type, or values too large.
    """
    given = np.asarray(values)
    if given.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, got {given.shape}")
    if given.dtype.kind not in "iu" and given.size:
        raise ValueError(f"{name} must hold integers, got the type {given.dtype}")
    if given.dtype.kind == "u" and given.size and given.max() > np.iinfo(np.int64).max:
        raise ValueError(f"{name} holds the value {given.max()}, which is too large")
    array: IntArray = np.ascontiguousarray(given, dtype=np.int64).view()
    array.flags.writeable = False
    return array
