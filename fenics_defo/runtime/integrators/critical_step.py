"""The largest stable step of explicit methods on a model, and who goes beyond it."""

import math

import numpy as np

from fenics_defo.errors import StepSizeError
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.limits import leapfrog_limit
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.setting import Setting


def explicit_limit(
    model: MotionModel, inertia: Inertia, setting: Setting, *, name: str, allow_unstable: bool
) -> float:
    """Largest stable step [s] at rest and where the motion begins.

    A body that stiffens later has a smaller one.

    Args:
        model: what moves.
        inertia: its mass.
        setting: step, damping and start.
        name: of the method.
        allow_unstable: do not judge the step.

    Raises:
        StepSizeError: the step is beyond it.
    """
    rest = np.zeros(setting.shape[-1:])
    squares = []
    for q in (rest, setting.q):
        stiffness = model.law.evaluator(q.shape).force_and_stiffness(q)[1]
        finite = np.isfinite(stiffness).all()
        squares.append(inertia.squared_frequencies(stiffness).max() if finite else math.inf)
    omega = math.sqrt(max(*squares, 0.0))
    limit = leapfrog_limit(omega, setting.damping[1])
    if not (allow_unstable or setting.step <= limit):
        raise StepSizeError(
            f"the step of {setting.step:.6g} s is beyond {limit:.6g} s, the largest stable step of "
            f"{name} on this model; take 0.9 of that, an implicit method, fewer coordinates, or "
            "allow_unstable=True"
        )
    return limit
