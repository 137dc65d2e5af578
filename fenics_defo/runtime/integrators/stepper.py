"""What all integrators are to their users: time, state, energies, one step after the other."""

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError, DivergenceError, LoadError
from fenics_defo.runtime.integrators.energies import Energies, Work, plain
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Scheme
from fenics_defo.runtime.integrators.setting import Setting

Array = NDArray[np.float64]


class Stepper:
    """A motion M a + alpha M v + beta K(q) v + f(q) = g of a reduced model, step by step.

    Coordinates are (r,), or (b, r) for b bodies of the same model at once.

    Args:
        model: what moves.
        inertia: its mass.
        setting: how the motion begins and is stepped.
        scheme: the method.
        energies: whether `energies` is asked for, which adds some ten calls of NumPy to a step.
    """

    #: Weight in the work of a step of the forces at its end.
    end_weight: ClassVar[float] = 0.5
    #: Whether a step takes the load at its start, not that at its end.
    load_at_start: ClassVar[bool] = False

    def __init__(
        self,
        model: MotionModel,
        inertia: Inertia,
        setting: Setting,
        scheme: Scheme,
        *,
        energies: bool,
    ) -> None:
        self.model, self.step, self.damping = model, setting.step, setting.damping
        self._inertia, self._scheme, self._shape = inertia, scheme, setting.shape
        self._none = np.zeros(setting.shape)
        self._want_energies = energies
        self._work: Work | None = None
        self._begin(setting.q, setting.v, setting.load, time=0.0)

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self._origin + self.steps * self.step

    @property
    def load_time(self) -> float:
        """Time [s] whose load the next `advance` takes."""
        return self.time if self.load_at_start else self._origin + (self.steps + 1) * self.step

    @property
    def q(self) -> Array:
        """Coordinates of the last good state, a copy of the shape (r,) or (b, r)."""
        return np.array(self._scheme.q)

    @property
    def v(self) -> Array:
        """Velocities of the last good state, likewise [1/s]."""
        return np.array(self._scheme.v)

    @property
    def a(self) -> Array:
        """Accelerations of the last good state, likewise [1/s²]."""
        return np.array(self._scheme.a)

    @property
    def iterations(self) -> int:
        """Linear solves of the last step where Newton's method converges to a tolerance, else 0."""
        return int(getattr(self._scheme, "iterations", 0))

    @property
    def energies(self) -> Energies:
        """Energies of the last good state.

        A method that takes the load at the start of a step reckons with the last load given for
        the end of the last step.

        Raises:
            DefoError: they were not asked for.
        """
        if self._work is None:
            raise DefoError(
                f"this {type(self).__name__} does not count energies; make it with energies=True"
            )
        q, v = self._scheme.q, self._scheme.v
        return Energies(
            kinetic=plain(0.5 * (v * self._inertia.apply(v)).sum(axis=-1)),
            strain=plain(self.model.energy(q)),
            external=plain(self._work.external),
            dissipated=plain(self._work.dissipated),
        )

    def advance(self, load: Array | None = None) -> None:
        """Do one step.

        Args:
            load: generalised force (r,) or (b, r) at `load_time`; None for none.

        Raises:
            DivergenceError: numbers became infinite, or equations were not solved; the last good
                state stands.
            LoadError: a load of another shape.
        """
        if load is None:
            load = self._none
        elif load.__class__ is not np.ndarray or load.shape != self._shape:
            load = self._as_force("the load of a step", load)
        try:
            size = self._scheme.advance(load)
        except (np.linalg.LinAlgError, FloatingPointError, RuntimeWarning):
            size = self._advance_quietly(load)
        if not size < np.inf:
            raise self._divergence(load)
        self.steps += 1
        if self._work is not None:
            self._work.add_step(load)

    def kick(self, momentum: ArrayLike, *, load: ArrayLike | None = None) -> None:
        """Change the velocities by M⁻¹ times an impulse.

        Args:
            momentum: generalised impulse (r,) or (b, r).
            load: generalised force at this time, from which a damped body gets its acceleration
                anew; None for none.

        Raises:
            LoadError: arrays of another shape, or not finite.
        """
        blow = self._as_force("an impulse", momentum)
        force = self._none if load is None else self._as_force("the load at an impulse", load)
        if not (np.isfinite(blow).all() and np.isfinite(force).all()):
            raise LoadError("an impulse and its load must be finite numbers; check their source")
        scheme, before = self._scheme, self.v
        after, q = before + self._inertia.acceleration(blow), self.q
        a = self._acceleration(q, after, force) if any(self.damping) else self.a
        scheme.place(q, after, a)
        if self._work is not None:
            self._work.add_blow(blow, before, after)

    def restart(
        self,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        *,
        load: ArrayLike | None = None,
        time: float = 0.0,
    ) -> None:
        """Begin again from coordinates and velocities; energies are counted from zero.

        Args:
            q: coordinates (r,) or (b, r); rest if not given.
            v: velocities, likewise.
            load: generalised force at this time, for the acceleration; None for none.
            time: [s].

        Raises:
            LoadError: arrays of another shape, or not finite.
        """
        fields = []
        for name, given in (("q", q), ("v", v), ("load", load)):
            field = self._none if given is None else self._as_force(name, given)
            if not np.isfinite(field).all():
                raise LoadError(f"{name} holds numbers that are not finite")
            fields.append(np.broadcast_to(field, self._shape))
        if not np.isfinite(time):
            raise LoadError(f"time must be a finite number [s], got {time!r}")
        self._begin(*fields, time=float(time))

    def _advance_quietly(self, load: Array) -> float:
        """The step once more, where NumPy's warnings are errors: the numbers decide, not they."""
        try:
            with np.errstate(all="ignore"):
                return self._scheme.advance(load)
        except np.linalg.LinAlgError:
            return np.nan

    def _begin(self, q: Array, v: Array, load: Array, *, time: float) -> None:
        scheme = self._scheme
        #: Number of steps done.
        self.steps = 0
        self._origin = time
        scheme.place(q, v, self._none)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            a = self._acceleration(q, v, load)
        if not np.isfinite(a).all():
            raise LoadError(
                "the motion cannot begin: the forces at the initial q and v are infinite or no "
                "numbers; begin nearer to rest"
            )
        scheme.place(q, v, a)
        if self._want_energies:
            self._work = Work(
                scheme,
                self._inertia,
                self.damping,
                end_weight=self.end_weight,
                load=np.array(load),
                load_at_start=self.load_at_start,
            )

    def _acceleration(self, q: Array, v: Array, load: Array) -> Array:
        """M⁻¹ (g - f - C v) for the scheme's present q and any v."""
        here, (alpha, beta) = self._scheme.here, self.damping
        rest = load - here.force_at(q)
        if beta:
            rest -= beta * here.stiffness_times(q, v)
        return self._inertia.acceleration(rest) - alpha * v

    def _as_force(self, what: str, given: ArrayLike) -> Array:
        values = np.asarray(given, dtype=np.float64)
        if values.shape not in (self._shape, self._shape[-1:]):
            raise LoadError(
                f"{what} must have the shape {self._shape}"
                + (f" or {self._shape[-1:]}" if len(self._shape) == 2 else "")
                + f", got {values.shape}; project nodal forces with the model's own methods"
            )
        return np.broadcast_to(values, self._shape)

    def _divergence(self, load: Array) -> DivergenceError:
        reason = "the coordinates or forces became infinite or no number"
        if not np.isfinite(load).all():
            reason = "the load is not finite"
        elif len(self._shape) == 2:
            failed = np.flatnonzero(~np.isfinite(self._scheme.trial()).all(axis=-1))
            if failed.size:
                names = ", ".join(map(str, failed[:5])) + (", ..." if failed.size > 5 else "")
                reason += f" in bodies {names} of {self._shape[0]}, counted from 0"
        return DivergenceError(
            f"no step of {self.step:.6g} s was found at {self.time:.6g} s: {reason}. The state at "
            "that time stands; try a smaller step, more damping, BackwardEuler, more Newton "
            "iterations, or smaller loads",
            time=self.time,
            step=self.step,
            reason=reason,
        )
