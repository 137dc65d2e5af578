"""What all integrators are given, checked."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import LoadError, SolverError, StepSizeError
from fenics_defo.runtime.integrators.motion_model import MotionModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """How a motion begins and is stepped.

    Args:
        step: [s].
        damping: Rayleigh's (alpha [1/s], beta [s]).
        shape: of the coordinates, (r,), or (b, r) for b bodies.
        q: coordinates at the start, of this shape.
        v: their velocities.
        load: generalised force at the start.
    """

    step: float
    damping: tuple[float, float]
    shape: tuple[int, ...]
    q: Array
    v: Array
    load: Array


def check_setting(
    model: MotionModel,
    *,
    step: float,
    damping: tuple[float, float] | None,
    q: ArrayLike | None,
    v: ArrayLike | None,
    load: ArrayLike | None,
    batch: int | None,
) -> Setting:
    """Check the arguments that all integrators share.

    Args:
        model: what moves.
        step: [s].
        damping: None for the model's own.
        q: coordinates at the start (r,) or (b, r); None for rest.
        v: their velocities, likewise.
        load: generalised force at the start, likewise.
        batch: number b of bodies; None for what the arrays tell, and for one body of (r,).

    Raises:
        LoadError: arrays of another shape or not finite, or a damping that is negative.
        StepSizeError: the step is not positive and finite.
    """
    given = {"q": q, "v": v, "load": load}
    arrays = {
        name: _numbers(name, value, model.size)
        for name, value in given.items()
        if value is not None
    }
    if batch is None:
        batches = [len(array) for array in arrays.values() if array.ndim == 2]
        batch = batches[0] if batches else None
    elif isinstance(batch, bool) or not isinstance(batch, int) or batch < 1:
        raise LoadError(f"batch must be a number of bodies from 1, or None for one, got {batch!r}")
    shape = (model.size,) if batch is None else (batch, model.size)
    for name, array in arrays.items():
        if array.shape not in (shape, shape[-1:]):
            raise LoadError(
                f"{name} must have the shape {shape} or {shape[-1:]}, got {array.shape}"
            )
    fields = {name: np.array(np.broadcast_to(arrays.get(name, 0.0), shape)) for name in given}
    return Setting(
        step=check_step(step), damping=check_damping(model, damping), shape=shape, **fields
    )


def check_step(step: float) -> float:
    """The step as a float.

    Raises:
        StepSizeError: it is not positive and finite.
    """
    if not (_is_number(step) and 0.0 < step < math.inf):
        raise StepSizeError(f"the time step must be positive and finite [s], got {step!r}")
    return float(step)


def check_damping(model: MotionModel, damping: object) -> tuple[float, float]:
    """Rayleigh's (alpha, beta); the model's own for None.

    Raises:
        LoadError: not two numbers from 0.
    """
    given = model.damping if damping is None else damping
    pair = tuple(given) if isinstance(given, tuple | list) else ()
    if len(pair) != 2 or not all(_is_number(x) and 0.0 <= x < math.inf for x in pair):
        raise LoadError(
            "damping must be two numbers from 0, (alpha [1/s], beta [s]) of C = alpha M + beta K, "
            f"got {given!r}"
        )
    return float(pair[0]), float(pair[1])


def check_newton(iterations: int | None, tolerance: float, most: int) -> None:
    """Check the arguments of Newton's method.

    Raises:
        SolverError: one is out of range.
    """
    if iterations is not None and not _is_count(iterations):
        raise SolverError(
            "newton must be a whole number from 1, or None to iterate until newton_tolerance, "
            f"got {iterations!r}"
        )
    if not (_is_number(tolerance) and 0.0 < tolerance < 1.0):
        raise SolverError(f"newton_tolerance must be between 0 and 1, got {tolerance!r}")
    if not _is_count(most):
        raise SolverError(f"newton_iterations must be a whole number from 1, got {most!r}")


def _numbers(name: str, given: ArrayLike, size: int) -> Array:
    try:
        values = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if not (values.ndim in (1, 2) and values.shape[-1] == size and values.size):
        raise LoadError(
            f"{name} must be numbers of the shape ({size},), or (b, {size}) for b bodies, "
            f"got {np.shape(values) if values.size else given!r}"
        )
    if not np.isfinite(values).all():
        raise LoadError(f"{name} holds numbers that are not finite; check how it was computed")
    return values


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.floating) and not isinstance(value, bool)


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value > 0
