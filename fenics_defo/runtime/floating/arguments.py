"""Checks of what the user gives a floating body."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError, LoadError, SolverError, StepSizeError
from fenics_defo.runtime.floating.rotations import from_quaternion
from fenics_defo.runtime.floating.step import NewtonSettings

Array = NDArray[np.float64]

# How far a rotation given by the user may be from one, as numbers typed with seven digits are.
_ROTATION = 1e-6


def checked_step(step: float) -> float:
    """The step [s], positive and finite."""
    if not (_is_number(step) and 0.0 < step < math.inf):
        raise StepSizeError(f"the time step must be positive and finite [s], got {step!r}")
    return float(step)


def checked_damping(damping: tuple[float, float]) -> tuple[float, float]:
    """(alpha, beta), two numbers that are not negative."""
    pair = tuple(damping) if isinstance(damping, tuple | list) else ()
    if len(pair) != 2 or not all(_is_number(x) and 0.0 <= x < math.inf for x in pair):
        raise LoadError(
            "damping must be two numbers from 0, (alpha [1/s], beta [s]) of C = alpha M + beta K, "
            f"got {damping!r}"
        )
    return float(pair[0]), float(pair[1])


def checked_newton(iterations: int | None, tolerance: float, most: int) -> NewtonSettings:
    """Settings of Newton's method."""
    if iterations is not None and not (_is_whole(iterations) and iterations > 0):
        raise SolverError(
            "newton must be a whole number from 1, or None to iterate until newton_tolerance, "
            f"got {iterations!r}"
        )
    if not (_is_number(tolerance) and 0.0 < tolerance < 1.0):
        raise SolverError(f"newton_tolerance must be between 0 and 1, got {tolerance!r}")
    if not (_is_whole(most) and most > 0):
        raise SolverError(f"newton_iterations must be a whole number from 1, got {most!r}")
    return NewtonSettings(iterations, float(tolerance), most)


def checked_vector(name: str, given: ArrayLike, *, size: int = 3) -> Array:
    """Finite numbers (size,) or, for a batch, (b, size); a copy."""
    values = _numbers(given)
    if not (values.ndim in (1, 2) and values.shape[-1] == size and np.isfinite(values).all()):
        raise LoadError(
            f"{name} of a floating body must be finite numbers of the shape ({size},), or "
            f"(b, {size}) for b bodies, got {_told(given)}"
        )
    return values


def checked_rotation(given: ArrayLike) -> Array:
    """Rotations (3, 3) or (b, 3, 3) from matrices, or from quaternions (4,) or (b, 4)."""
    values = _numbers(given)
    if values.ndim in (1, 2) and values.shape[-1] == 4:
        norm = np.linalg.norm(values, axis=-1, keepdims=True)
        if (np.abs(norm - 1.0) <= _ROTATION).all():
            return from_quaternion(values / norm)
    elif values.ndim in (2, 3) and values.shape[-2:] == (3, 3) and np.isfinite(values).all():
        product = values @ np.swapaxes(values, -1, -2)
        if (np.abs(product - np.eye(3)) <= _ROTATION).all() and (np.linalg.det(values) > 0).all():
            left, _, right = np.linalg.svd(values)
            return np.asarray(left @ right)
    raise LoadError(
        "rotation of a floating body must be a rotation matrix (3, 3) or a unit quaternion (4,), "
        f"scalar first, got {_told(given)}"
    )


def checked_forces(
    forces: Sequence[tuple[int, ArrayLike]], rows: Mapping[int, int]
) -> tuple[NDArray[np.int64], Array]:
    """Rows of the nodes (p,) and forces (..., p, 3) [N] upon them."""
    found, vectors = [], []
    for item in forces:
        if not isinstance(item, tuple | list) or len(item) != 2:
            raise LoadError(f"a force is a pair of a node and a vector (3,) [N], got {item!r}")
        node, vector = item
        if not isinstance(node, int | np.integer) or int(node) not in rows:
            raise LoadError(
                f"node {node!r} is not stored in this model, which has {len(rows)} nodes; name it "
                "among the outputs when the body is reduced"
            )
        found.append(rows[int(node)])
        vectors.append(checked_vector("a force", vector))
    if not found:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    shape = np.broadcast_shapes(*(vector.shape for vector in vectors))
    stacked = np.stack([np.broadcast_to(vector, shape) for vector in vectors], axis=-2)
    return np.array(found, np.int64), stacked


def common_batch(*batches: tuple[int, ...]) -> tuple[int, ...]:
    """The leading axes that all initial values have or are repeated along."""
    try:
        batch = np.broadcast_shapes(*batches)
    except ValueError as error:
        sizes = sorted({b[0] for b in batches if b})
        raise DefoError(
            f"the initial values are for batches of different sizes {sizes}; give one row for "
            "each body, or one for all"
        ) from error
    return batch


def check_batches(given: Mapping[str, tuple[int, ...]], batch: tuple[int, ...]) -> None:
    """Check that loads are for one body, or for each of the batch."""
    for name, leading in given.items():
        if leading and leading != batch:
            raise LoadError(
                f"{name} was given for {leading[0]} bodies, but there are {math.prod(batch)} here; "
                "give one row for each, or one for all"
            )


def _numbers(given: ArrayLike) -> Array:
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.empty(())


def _told(given: ArrayLike) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"an array of the shape {np.shape(given)}"


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.floating) and not isinstance(value, bool)


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)
