"""What explicit integrators have in common: a largest stable step, and how they are made."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.runtime.integrators.critical_step import explicit_limit
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Scheme
from fenics_defo.runtime.integrators.setting import check_setting
from fenics_defo.runtime.integrators.stepper import Stepper

Array = NDArray[np.float64]


class ExplicitScheme(Protocol):
    """Makes an explicit method's scheme."""

    def __call__(
        self,
        model: MotionModel,
        inertia: Inertia,
        *,
        step: float,
        damping: tuple[float, float],
        shape: tuple[int, ...],
    ) -> Scheme:
        """The scheme for a step [s], a damping, and coordinates of a shape."""


class ExplicitStepper(Stepper):
    """A `Stepper` that refuses steps beyond its limit.

    Args:
        model: what moves, of r coordinates.
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.
        energies: whether `energies` is asked for.
        allow_unstable: go on where the step is beyond the limit.

    Raises:
        LoadError: damping or arrays out of range.
        StepSizeError: the step is not positive and finite, or beyond `critical_step`.
        SolverError: a mass that is not positive definite.
    """

    def __init__(
        self,
        model: MotionModel,
        *,
        step: float,
        damping: tuple[float, float] | None = None,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        load: ArrayLike | None = None,
        batch: int | None = None,
        energies: bool = False,
        allow_unstable: bool = False,
    ) -> None:
        setting = check_setting(model, step=step, damping=damping, q=q, v=v, load=load, batch=batch)
        inertia = Inertia(model.mass, setting.shape)
        #: Largest stable step [s] at rest and where the motion begins.
        self.critical_step = explicit_limit(
            model, inertia, setting, name=type(self).__name__, allow_unstable=allow_unstable
        )
        scheme = self._scheme_type()(
            model, inertia, step=setting.step, damping=setting.damping, shape=setting.shape
        )
        super().__init__(model, inertia, setting, scheme, energies=energies)

    def _scheme_type(self) -> ExplicitScheme:
        raise NotImplementedError
