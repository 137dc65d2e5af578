"""Checks of what the user asks of a simulation, before anything is done."""

import math

from fenics_defo.analysis.implicit_step import NewtonSettings
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.errors import LoadError, SolverError, StepSizeError


def check_request(
    integrator: Integrator,
    step: float,
    damping: tuple[float, float],
    newton: NewtonSettings,
    halvings: int,
) -> None:
    """Check the arguments that need no body.

    Raises:
        LoadError: no integrator, or a damping that is negative or not finite.
        StepSizeError: the step is not positive and finite.
        SolverError: settings of Newton's method out of range.
    """
    if isinstance(integrator, type) or not isinstance(integrator, Integrator):
        raise LoadError(
            "an integrator must be one such as ImplicitNewmark() or BackwardEuler(), "
            f"got {integrator!r}"
        )
    if not _number(step) or not 0.0 < step < math.inf:
        raise StepSizeError(f"the time step must be positive and finite [s], got {step!r}")
    pair = tuple(damping) if isinstance(damping, tuple | list) else ()
    if len(pair) != 2 or not all(_number(x) and 0.0 <= x < math.inf for x in pair):
        raise LoadError(
            "damping must be two numbers from 0, (alpha [1/s], beta [s]) of C = alpha M + beta K, "
            f"got {damping!r}"
        )
    if newton.iterations is not None and not (_whole(newton.iterations) and newton.iterations > 0):
        raise SolverError(
            "newton must be a whole number from 1, or None to iterate until newton_tolerance, "
            f"got {newton.iterations!r}"
        )
    if not (_number(newton.tolerance) and 0.0 < newton.tolerance < 1.0):
        raise SolverError(f"newton_tolerance must be between 0 and 1, got {newton.tolerance!r}")
    if not (_whole(newton.most) and newton.most > 0):
        raise SolverError(f"newton_iterations must be a whole number from 1, got {newton.most!r}")
    if not (_whole(halvings) and 0 <= halvings <= 40):
        raise StepSizeError(f"max_halvings must be a whole number from 0 to 40, got {halvings!r}")


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)
