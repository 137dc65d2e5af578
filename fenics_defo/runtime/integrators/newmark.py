"""Newmark's implicit method."""

import math

from numpy.typing import ArrayLike

from fenics_defo.errors import LoadError
from fenics_defo.runtime.integrators.implicit_rule import ImplicitRule
from fenics_defo.runtime.integrators.implicit_scheme import implicit_scheme
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.setting import check_setting
from fenics_defo.runtime.integrators.stepper import Stepper


class ImplicitNewmark(Stepper):
    """q' = q + h v + h² ((½ - β) a + β a'),  v' = v + h ((1 - γ) a + γ a'),  M a' + C v' + f' = g'.

    C = alpha M + beta K(q) with the tangent at the present iterate: with newton = 1 that at the
    start of the step, which makes stiffness damping of nonlinear models first order. The default,
    average acceleration, is of second order, stable for any step on linear models, and keeps their
    energy exactly. γ > ½ damps the high frequencies and is of first order.

    Args:
        model: what moves, of r coordinates.
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        newton: iterations of Newton's method a step; 1 is semi-implicit: one linearised solve.
            None iterates until ``newton_tolerance`` is met.
        newton_tolerance: largest ‖r‖ / max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖) [-], where newton is None.
        newton_iterations: most iterations, where newton is None.
        beta: β, positive [-].
        gamma: γ, at least ½ [-].
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise: gives the first acceleration.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.
        energies: whether `energies` is asked for.

    Raises:
        LoadError: β, γ, damping, or arrays out of range.
        StepSizeError: the step is not positive and finite.
        SolverError: a mass that is not positive definite, or settings of Newton's method.

    References: Newmark, J. Eng. Mech. Div. ASCE 85(3), 1959; Hughes, The Finite Element Method
    (2000), section 9.1.
    """

    def __init__(
        self,
        model: MotionModel,
        *,
        step: float,
        damping: tuple[float, float] | None = None,
        newton: int | None = 1,
        newton_tolerance: float = 1e-6,
        newton_iterations: int = 20,
        beta: float = 0.25,
        gamma: float = 0.5,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        load: ArrayLike | None = None,
        batch: int | None = None,
        energies: bool = False,
    ) -> None:
        setting = check_setting(model, step=step, damping=damping, q=q, v=v, load=load, batch=batch)
        inertia = Inertia(model.mass, setting.shape)
        scheme = implicit_scheme(
            model,
            inertia,
            setting,
            newmark_rule(setting.step, beta, gamma),
            newton=newton,
            tolerance=newton_tolerance,
            most=newton_iterations,
        )
        super().__init__(model, inertia, setting, scheme, energies=energies)


def newmark_rule(step: float, beta: float, gamma: float) -> ImplicitRule:
    """Newmark's method for a step [s].

    Raises:
        LoadError: β or γ out of range, or 2 β < γ, where the method is not stable for any step.
    """
    if not (gamma >= 0.5 and 2.0 * beta >= gamma and beta < math.inf):
        raise LoadError(
            "ImplicitNewmark is stable for any step where gamma >= 0.5 and 2 beta >= gamma, "
            f"got beta = {beta!r} and gamma = {gamma!r}; the usual values are 0.25 and 0.5"
        )
    ratio = gamma / beta
    return ImplicitRule(
        velocity_rate=ratio / step,
        acceleration_rate=1.0 / (beta * step**2),
        velocity_of_v=1.0 - ratio,
        velocity_of_a=step * (1.0 - 0.5 * ratio),
        acceleration_of_v=-1.0 / (beta * step),
        acceleration_of_a=1.0 - 0.5 / beta,
    )
