"""A reduced body that flies: it tumbles, falls and is pushed while it deforms."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError, DivergenceError, LoadError
from fenics_defo.runtime.floating import rotations
from fenics_defo.runtime.floating.arguments import (
    checked_damping,
    checked_forces,
    checked_newton,
    checked_rotation,
    checked_step,
    checked_vector,
)
from fenics_defo.runtime.floating.frame import FloatingFrame
from fenics_defo.runtime.floating.inertia import Inertia
from fenics_defo.runtime.floating.loads import Loads
from fenics_defo.runtime.floating.state import FloatingState
from fenics_defo.runtime.floating.step import FloatingStep, StepFailure

Array = NDArray[np.float64]

type Coupling = Literal["full", "none"]
type Force = tuple[int, ArrayLike]


class FlyingModel(Protocol):
    """What `FloatingBody` needs of a reduced model."""

    @property
    def law(self) -> Any:
        """Elastic force law of q."""

    @property
    def frame(self) -> FloatingFrame | None:
        """Integrals of mass; None for a body that is held."""

    @property
    def damping(self) -> tuple[float, float]:
        """(alpha [1/s], beta [s])."""

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Stored nodes (p,), zero-based in the file's order."""

    @property
    def points(self) -> Array:
        """Their places at rest (p, 3) [m]."""

    @property
    def shapes(self) -> Array:
        """Their displacements by the shapes (p, 3, r)."""


@dataclass(frozen=True, slots=True)
class FloatingEnergies:
    """Energies of a floating body [J]; with the leading axes of a batch.

    Args:
        kinetic: of the whole motion.
        strain: elastic.
    """

    kinetic: Array
    strain: Array


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
            deforms as if it did not spin; cheaper, and right to first order for slow spins.
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

    References: Shabana, Dynamics of Multibody Systems, section 5; Hairer, Lubich and Wanner,
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
                "this model has no floating frame, so it cannot fly; reduce a body without "
                "constraints, or use an integrator of held bodies such as ImplicitNewmark"
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
        self._batch = _common_batch(*(x.shape[:-1] for x in given.values()), turned.shape[:-2])
        self.model = model
        self.step = checked_step(step)
        self.coupling = coupling
        self._frame = frame
        self._steps = 0
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
        self._now = self._started(given, np.broadcast_to(turned, (*self._batch, 3, 3)))

    def _started(self, given: dict[str, Array], rotation: Array) -> FloatingState:
        full = {k: np.broadcast_to(x, (*self._batch, x.shape[-1])) for k, x in given.items()}
        spin = _times(np.swapaxes(rotation, -1, -2), full["angular_velocity"])
        inertia = self._stepper.inertia
        at = inertia.at(full["q"])
        angular = _times(at.inertia, spin) + _times(at.coupling, full["v"])
        by_spin = (spin[..., None, :] @ at.coupling)[..., 0, :]
        return FloatingState(
            time=0.0,
            position=full["position"],
            rotation=rotation,
            velocity=full["velocity"],
            spin=spin,
            q=full["q"],
            v=full["v"],
            angular=_times(rotation, angular),
            momenta=_times(inertia.mass, full["v"]) + by_spin,
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
        return _times(self._now.rotation, self._now.spin)

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
        now, inertia = self._now, self._stepper.inertia
        at = inertia.at(now.q)
        turning = 0.5 * _times(at.inertia, now.spin) + _times(at.coupling, now.v)
        kinetic = 0.5 * self._frame.mass * (now.velocity**2).sum(axis=-1)
        kinetic += (now.spin * turning).sum(axis=-1)
        kinetic += 0.5 * (now.v * _times(inertia.mass, now.v)).sum(axis=-1)
        return FloatingEnergies(kinetic, np.asarray(self.model.law.energy(now.q)))

    def momentum(self) -> tuple[Array, Array]:
        """Momentum [kg m/s] and angular momentum about the world's origin [kg m²/s], (..., 3)."""
        now = self._now
        at = self._stepper.inertia.at(now.q)
        linear = self._frame.mass * now.velocity
        angular = _times(now.rotation, _times(at.inertia, now.spin) + _times(at.coupling, now.v))
        return linear, angular + rotations.cross(now.position, linear)

    def world_points(self) -> Array:
        """Where the model's stored nodes are (..., p, 3) [m]."""
        now, frame = self._now, self._frame
        shapes = self.model.shapes - frame.mean
        inside = self.model.points - frame.centre + (shapes @ now.q[..., None, :, None])[..., 0]
        turned = inside @ np.swapaxes(now.rotation, -1, -2)
        return np.asarray(now.position[..., None, :] + turned)

    def world_displacement(self) -> Array:
        """How far the stored nodes are from where they are at rest in the model (..., p, 3) [m]."""
        return self.world_points() - self.model.points

    def advance(
        self,
        load: ArrayLike | None = None,
        *,
        gravity: ArrayLike = (0.0, 0.0, 0.0),
        forces: Iterable[Force] = (),
    ) -> None:
        """Do one step under loads that act at its end; between the ends they change linearly.

        The loads of the first step act from time zero on.

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
                start = self._stepper.begun(self._now, loads) if self._steps == 0 else self._now
                reached = self._stepper.advance(start, loads)
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

    def _loads(self, load: ArrayLike | None, gravity: ArrayLike, forces: Sequence[Force]) -> Loads:
        r = self._frame.size
        push = checked_vector("load", np.zeros(r) if load is None else load, size=r)
        fall = checked_vector("gravity", gravity)
        rows, vectors = checked_forces(forces, self._rows)
        batches = {"load": push.shape[:-1], "gravity": fall.shape[:-1]}
        for name, batch in (batches | {"forces": vectors.shape[:-2]}).items():
            if batch and batch != self._batch:
                raise LoadError(
                    f"{name} was given for {batch[0]} bodies, but there are "
                    f"{math.prod(self._batch)} here; give one row for each, or one for all"
                )
        return Loads(
            push=push,
            gravity=fall,
            places=self.model.points[rows] - self._frame.centre,
            shapes=self.model.shapes[rows] - self._frame.mean,
            forces=vectors,
        )


def _common_batch(*batches: tuple[int, ...]) -> tuple[int, ...]:
    try:
        batch = np.broadcast_shapes(*batches)
    except ValueError as error:
        sizes = sorted({b[0] for b in batches if b})
        raise DefoError(
            f"the initial values are for batches of different sizes {sizes}; give one row for "
            "each body, or one for all"
        ) from error
    return batch


def _times(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])
