"""Euler's implicit method."""

from typing import ClassVar

from numpy.typing import ArrayLike

from fenics_defo.runtime.integrators.implicit_rule import ImplicitRule
from fenics_defo.runtime.integrators.implicit_scheme import implicit_scheme
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.setting import check_setting
from fenics_defo.runtime.integrators.stepper import Stepper


class BackwardEuler(Stepper):
    """q' = q + h v',  v' = v + h a',  M a' + C v' + f' = g'.

    C = alpha M + beta K(q) with the tangent at the present iterate. Of first order; stable for any
    step on linear models, and damps what it does not resolve.

    Args:
        model: what moves, of r coordinates.
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        newton: iterations of Newton's method a step; None iterates until ``newton_tolerance``.
        newton_tolerance: largest ‖r‖ / max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖) [-], where newton is None.
        newton_iterations: most iterations, where newton is None.
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.
        energies: whether `energies` is asked for.

    Raises:
        LoadError: damping or arrays out of range.
        StepSizeError: the step is not positive and finite.
        SolverError: a mass that is not positive definite, or settings of Newton's method.

    References: Baraff and Witkin, Large steps in cloth simulation, SIGGRAPH 1998.
    """

    #: Forces at the end: what then lacks in the balance is the method's own damping.
    end_weight: ClassVar[float] = 1.0

    def __init__(
        self,
        model: MotionModel,
        *,
        step: float,
        damping: tuple[float, float] | None = None,
        newton: int | None = 1,
        newton_tolerance: float = 1e-6,
        newton_iterations: int = 20,
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
            euler_rule(setting.step),
            newton=newton,
            tolerance=newton_tolerance,
            most=newton_iterations,
        )
        super().__init__(model, inertia, setting, scheme, energies=energies)


def euler_rule(step: float) -> ImplicitRule:
    """Euler's implicit method for a step [s]."""
    return ImplicitRule(
        velocity_rate=1.0 / step,
        acceleration_rate=1.0 / step**2,
        velocity_of_v=0.0,
        velocity_of_a=0.0,
        acceleration_of_v=-1.0 / step,
        acceleration_of_a=0.0,
    )
