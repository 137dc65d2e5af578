"""Which scheme suits an implicit method."""

from fenics_defo.runtime.integrators.converged_step import ConvergedStep
from fenics_defo.runtime.integrators.implicit_rule import ImplicitRule, transitions
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.linear_step import LinearStep
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.newton_step import NewtonStep
from fenics_defo.runtime.integrators.scheme import Scheme
from fenics_defo.runtime.integrators.setting import Setting, check_newton


def implicit_scheme(
    model: MotionModel,
    inertia: Inertia,
    setting: Setting,
    rule: ImplicitRule,
    *,
    newton: int | None,
    tolerance: float,
    most: int,
) -> Scheme:
    """A scheme for an implicit rule.

    Args:
        model: what moves.
        inertia: its mass.
        setting: step, damping and shape.
        rule: the method's.
        newton: iterations a step; None: until ``tolerance`` is met.
        tolerance: largest relative residual.
        most: largest number of iterations.

    Raises:
        SolverError: settings of Newton's method out of range.
    """
    check_newton(newton, tolerance, most)
    maps = transitions(rule, setting.damping)
    if model.law.kind == "linear":
        return LinearStep(model, inertia, maps, shape=setting.shape)
    if newton is None:
        return ConvergedStep(
            model,
            inertia,
            rule,
            damping=setting.damping,
            tolerance=tolerance,
            most=most,
            shape=setting.shape,
        )
    return NewtonStep(model, inertia, maps, iterations=newton, shape=setting.shape)
