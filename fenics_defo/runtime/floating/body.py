"""A reduced body that flies: it tumbles, falls and is pushed while it deforms."""

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError, DivergenceError
from fenics_defo.runtime.floating import rotations
from fenics_defo.runtime.floating.arguments import (
    check_batches,
    checked_damping,
    checked_forces,
    checked_newton,
    checked_rotation,
    checked_step,
    checked_vector,
    common_batch,
)
from fenics_defo.runtime.floating.conserved import FloatingEnergies, kinetic_energy, momenta
from fenics_defo.runtime.floating.flying_model import FlyingModel
from fenics_defo.runtime.floating.inertia import Inertia
from fenics_defo.runtime.floating.loads import Loads
from fenics_defo.runtime.floating.products import times
from fenics_defo.runtime.floating.state import FloatingState
from fenics_defo.runtime.floating.step import FloatingStep, StepFailure

Array = NDArray[np.float64]

type Coupling = Literal["full", "none"]
type Force = tuple[int, ArrayLike]

_NO_GRAVITY = (0.0, 0.0, 0.0)


class FloatingBody:
    """Motion of a free-flying reduced body, x = c + R (X + U q), step by step.

    The equations are those of the floating frame of reference with the consistent mass (see
    `fenics_defo.runtime.floating.inertia`), the elastic force is the model's, and Rayleigh's
    damping C = alpha M + beta K(q) acts on the deformation alone: it takes no momentum. Each step
    is the trapezoidal rule in the momenta, of second order and implicit in the deformation, so
    stiff shapes do not limit it; the rotation should stay well below half a turn a step. Without
    loads momentum and angular momentum stay the same to round-off, whatever the step and the
    number of Newton iterations; the energy has an error of second order that does not drift when
    Newton's method converges.

    A spin stretches and bends the body by its shapes only. That a stretched body is stiffer in
    bending is a matter of the force law and the shapes: a cubic law with modal derivatives has it,
    a linear law has not, and then a fast spin softens the body until it diverges.

    A batch (b, ...) of bodies of one model is moved at once when ``q`` or another of the initial
    values has a leading axis.

    Args:
        model: reduced model with a floating frame.
        step: time step h [s].
        damping: (alpha [1/s], beta [s]); the model's own if not given.
        newton: Newton iterations a step; None iterates until ``newton_tolerance`` is met.
        newton_tolerance: largest residual of converged Newton relative to the largest term [-].
        newton_iterations: most iterations of converged Newton.
        coupling: "full", or "none". "none" neglects the inertial coupling of rotation and
            deformation: centrifugal, Coriolis and Euler forces upon the deformation, the change of
            inertia by it and its angular momentum. The body then spins as if it were rigid and
            deforms as if it did not spin: for spins that are slow beside its lowest frequency.
        position: of the centre of mass (3,) [m]; the one at rest if not given.
        rotation: from the frame's axes to the world's, a matrix (3, 3) or a unit quaternion (4,),
            scalar first; none if not given.
        velocity: of the centre of mass (3,) [m/s].
        angular_velocity: of the frame, world axes (3,) [rad/s].
        q: coordinates of the deformation (r,); rest if not given.
        v: their rates (r,).

    Raises:
        DefoError: the model has no floating frame, or an argument is out of range.
        StepSizeError: the step is not positive and finite.

    References: Shabana, Dynamics of Multibody Systems, chapter 5; Hairer, Lubich and Wanner,
    Geometric Numerical Integration (2006), on symmetric methods.
    """

    def __init__(
        self,
        model: FlyingModel,
        *,
        step: float,
        damping: tuple[float, float] | None = None,
        newton: int | None = 1,
        newton_tolerance: float = 1e-9,
        newton_iterations: int = 20,
        coupling: Coupling = "full",
        position: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
    ) -> None:
        frame = model.frame
        if frame is None:
            raise DefoError(
                "this model has no floating frame and cannot fly; reduce a body that nothing "
                "holds, or take an integrator of held bodies such as ImplicitNewmark"
            )
        if coupling not in ("full", "none"):
            raise DefoError(f"coupling must be 'full' or 'none', got {coupling!r}")
        r = frame.size
        given = {
            "position": checked_vector("position", frame.centre if position is None else position),
            "velocity": checked_vector("velocity", velocity),
            "angular_velocity": checked_vector("angular_velocity", angular_velocity),
            "q": checked_vector("q", np.zeros(r) if q is None else q, size=r),
            "v": checked_vector("v", np.zeros(r) if v is None else v, size=r),
        }
        turned = checked_rotation(np.eye(3) if rotation is None else rotation)
        self._batch = common_batch(*(x.shape[:-1] for x in given.values()), turned.shape[:-2])
        self.model = model
        self.step = checked_step(step)
        self.coupling = coupling
        self._frame = frame
        self._steps = 0
        self._first: Loads | None = None
        self._no_loads: Loads | None = None
        self._rows = {int(node): row for row, node in enumerate(model.nodes)}
        self._stepper = FloatingStep(
            model.law,
            Inertia(frame, coupled=coupling == "full"),
            mass=frame.mass,
            damping=checked_damping(model.damping if damping is None else damping),
            step=self.step,
            newton=checked_newton(newton, newton_tolerance, newton_iterations),
            shape=(*self._batch, r),
        )
        self._no_loads = self._loads(None, _NO_GRAVITY, [])
        self._now = self._started(given, np.broadcast_to(turned, (*self._batch, 3, 3)))

    def _started(self, given: dict[str, Array], rotation: Array) -> FloatingState:
        full = {k: np.broadcast_to(x, (*self._batch, x.shape[-1])) for k, x in given.items()}
        spin = times(np.swapaxes(rotation, -1, -2), full["angular_velocity"])
        inertia = self._stepper.inertia
        at = inertia.at(full["q"])
        angular = times(at.inertia, spin) + times(at.coupling, full["v"])
        by_spin = (spin[..., None, :] @ at.coupling)[..., 0, :]
        return FloatingState(
            time=0.0,
            position=full["position"],
            rotation=rotation,
            velocity=full["velocity"],
            spin=spin,
            q=full["q"],
            v=full["v"],
            angular=times(rotation, angular),
            momenta=times(inertia.mass, full["v"]) + by_spin,
            push=np.zeros_like(full["q"]),
            force=np.zeros_like(spin),
            moment=np.zeros_like(spin),
        )

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self._now.time

    @property
    def steps(self) -> int:
        """Number of steps done."""
        return self._steps

    @property
    def position(self) -> Array:
        """Centre of mass (..., 3) [m]."""
        return self._now.position.copy()

    @property
    def rotation(self) -> Array:
        """From the frame's axes to the world's (..., 3, 3)."""
        return self._now.rotation.copy()

    @property
    def quaternion(self) -> Array:
        """The same as a unit quaternion (..., 4), scalar first and not negative."""
        return rotations.to_quaternion(self._now.rotation)

    @property
    def velocity(self) -> Array:
        """Of the centre of mass (..., 3) [m/s]."""
        return self._now.velocity.copy()

    @property
    def angular_velocity(self) -> Array:
        """Of the frame, in the world's axes (..., 3) [rad/s]."""
        return times(self._now.rotation, self._now.spin)

    @property
    def q(self) -> Array:
        """Coordinates of the deformation (..., r)."""
        return self._now.q.copy()

    @property
    def v(self) -> Array:
        """Their rates (..., r)."""
        return self._now.v.copy()

    @property
    def energies(self) -> FloatingEnergies:
        """Energies of the last good state."""
        kinetic = kinetic_energy(self._now, self._stepper.inertia, mass=self._frame.mass)
        return FloatingEnergies(kinetic, self.model.law.energy(self._now.q))

    def momentum(self) -> tuple[Array, Array]:
        """Momentum [kg m/s] and angular momentum about the world's origin [kg m²/s], (..., 3)."""
        return momenta(self._now, self._stepper.inertia, mass=self._frame.mass)

    def world_points(self) -> Array:
        """Where the model's stored nodes are (..., p, 3) [m]."""
        now, frame = self._now, self._frame
        shapes = self.model.shapes - frame.mean
        inside = self.model.points - frame.centre + (shapes @ now.q[..., None, :, None])[..., 0]
        return now.position[..., None, :] + inside @ np.swapaxes(now.rotation, -1, -2)

    def world_displacement(self) -> Array:
        """How far the stored nodes are from where they are at rest in the model (..., p, 3) [m]."""
        return self.world_points() - self.model.points

    def begin(
        self,
        load: ArrayLike | None = None,
        *,
        gravity: ArrayLike = _NO_GRAVITY,
        forces: Iterable[Force] = (),
    ) -> None:
        """Say which loads act at time zero, as `advance`; if not said, those of the first step.

        Raises:
            DefoError: as `advance`; or the motion has begun.
        """
        if self._steps:
            raise DefoError(f"the motion has begun {self._steps} steps ago; begin before the first")
        self._first = self._loads(load, gravity, list(forces))

    def advance(
        self,
        load: ArrayLike | None = None,
        *,
        gravity: ArrayLike = _NO_GRAVITY,
        forces: Iterable[Force] = (),
    ) -> None:
        """Do one step under loads that act at its end; between the ends they change linearly.

        Args:
            load: generalised load (r,) or (b, r) on the deformation alone: what has no resultant
                force and moment, such as an actuator. What has one belongs into ``forces``.
            gravity: acceleration (3,) or (b, 3) [m/s²], world axes.
            forces: pairs of a stored node and a force (3,) or (b, 3) [N], world axes.

        Raises:
            DefoError: a load of the wrong shape or not finite, or a node that is not stored.
            DivergenceError: the step failed; the last good state stands.
        """
        loads = self._loads(load, gravity, list(forces))
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            try:
                reached = self._stepper.advance(self._start(loads), loads)
                reason = "" if reached.is_finite() else "the motion became infinite or no number"
            except StepFailure as failure:
                reason = str(failure)
            except np.linalg.LinAlgError:
                reason = "the equations of the step are singular"
        if reason:
            raise DivergenceError(
                f"the step of {self.step:.6g} s from {self.time:.6g} s failed: {reason}; the last "
                "good state stands: take shorter steps, or more Newton iterations",
                time=self.time,
                step=self.step,
                reason=reason,
            )
        self._now = reached
        self._steps += 1

    def _start(self, loads: Loads) -> FloatingState:
        if self._steps:
            return self._now
        return self._stepper.begun(self._now, loads if self._first is None else self._first)

    def _loads(self, load: ArrayLike | None, gravity: ArrayLike, forces: Sequence[Force]) -> Loads:
        if load is None and gravity is _NO_GRAVITY and not forces and self._no_loads is not None:
            return self._no_loads
        r = self._frame.size
        push = checked_vector("load", np.zeros(r) if load is None else load, size=r)
        fall = checked_vector("gravity", gravity)
        rows, vectors = checked_forces(forces, self._rows)
        batches = {"load": push.shape[:-1], "gravity": fall.shape[:-1]}
        check_batches(batches | {"forces": vectors.shape[:-2]}, self._batch)
        return Loads(
            push=push,
            gravity=fall,
            places=self.model.points[rows] - self._frame.centre,
            shapes=self.model.shapes[rows] - self._frame.mean,
            forces=vectors,
        )
