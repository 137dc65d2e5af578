"""Where a reduced body rests under a load."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError, SolverError

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
_HOPELESS = 1e10
_CUTS = 12
# The slope along a search direction must fall to this part of what it was.
_SLOPE = 0.7


class Springy(Protocol):
    """A reduced model, as far as its equilibria go."""

    @property
    def size(self) -> int:
        """Number of coordinates r."""

    def force(self, q: Array) -> Array:
        """Internal force (r,)."""

    def stiffness(self, q: Array) -> Array:
        """Its derivative (r, r)."""


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """An equilibrium.

    Args:
        q: reduced coordinates (r,).
        residuals: ‖f - g‖ / max(‖f‖, ‖g‖) before each solve and after the last [-].
    """

    q: Array
    residuals: tuple[float, ...]


def find_rest(
    model: Springy,
    load: Array,
    *,
    q: Array | None = None,
    tolerance: float = 1e-8,
    iterations: int = 50,
) -> Rest:
    """Solve f(q) = g by Newton's method with full steps and, if that fails, with a line search.

    The search goes for where the residual is orthogonal to the direction: the least potential
    along it.

    Args:
        model: reduced model.
        load: reduced load g (r,).
        q: where to start (r,); at rest if not given.
        tolerance: largest residual relative to the larger of the forces [-].
        iterations: most solves.

    Returns:
        the equilibrium.

    Raises:
        DefoError: arrays of another shape, or not finite.
        SolverError: none was found.
    """
    start = np.zeros(model.size) if q is None else np.array(q, dtype=np.float64)
    for name, values in (("load", np.asarray(load)), ("q", start)):
        if values.shape != (model.size,) or not np.isfinite(values).all():
            raise DefoError(
                f"{name} of this model must be {model.size} finite numbers, got an array of the "
                f"shape {values.shape}"
            )
    for search in (False, True):
        residuals: list[float] = []
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            found = _newton(model, load, start, residuals, tolerance, iterations, search)
        if found is not None:
            return Rest(found, tuple(residuals))
    history = ", ".join(f"{residual:.1e}" for residual in residuals[-8:])
    raise SolverError(
        f"no equilibrium of the reduced model was found in {iterations} iterations (relative "
        f"residuals {history}); the body may buckle there, try smaller load steps"
    )


def _newton(
    model: Springy,
    load: Array,
    start: Array,
    residuals: list[float],
    tolerance: float,
    iterations: int,
    search: bool,
) -> Array | None:
    """The equilibrium, or None; the residuals go where the caller sees them."""
    q, first = start, 0.0
    for iteration in range(iterations + 1):
        force = np.array(model.force(q))
        rest = load - force
        size, scale = float(np.linalg.norm(rest)), _largest(force, load)
        first = first or scale
        residuals.append(size / scale if scale > 0.0 else size)
        if not size <= _HOPELESS * max(first, scale):
            return None
        stiffness = np.array(model.stiffness(q))
        # What rounding q leaves in the forces counts as nothing.
        rounding = 10.0 * _EPS * float(np.linalg.norm(np.abs(stiffness) @ np.abs(q)))
        if size <= max(tolerance * scale, rounding):
            return q
        if iteration == iterations:
            return None
        try:
            direction = np.linalg.solve(stiffness, rest)
        except np.linalg.LinAlgError:
            return None
        moved = _searched(model, load, q, direction, rest) if search else q + direction
        if moved is None:
            return None
        q = moved
    return None


def _searched(model: Springy, load: Array, q: Array, direction: Array, rest: Array) -> Array | None:
    """The next iterate: a full step, or less where that leads to infinity or up."""
    slope, length = float(direction @ -rest), 1.0
    if slope > 0.0:  # uphill, for the stiffness was not positive definite
        direction, slope = -direction, -slope
    for _ in range(_CUTS):
        trial = q + length * direction
        ahead = float(direction @ (model.force(trial) - load))
        if not np.isfinite(ahead):
            length *= 0.5
        elif ahead <= _SLOPE * abs(slope):
            return np.asarray(trial)
        else:
            # Regula falsi between here and there, kept off both ends.
            length *= min(max(slope / (slope - ahead), 0.1), 0.6)
    return None


def _largest(*fields: Array) -> float:
    return max(float(np.linalg.norm(field)) for field in fields)
