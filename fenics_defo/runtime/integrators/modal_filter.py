"""The exact recursive filter of linear models."""

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DivergenceError, LoadError, SolverError
from fenics_defo.runtime.integrators.filter_blocks import FilterBlocks
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.modal_response import modal_response
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.setting import check_setting

Array = NDArray[np.float64]

_ROWS = 128


class ModalFilter:
    """z'' + (alpha + beta ω²) z' + ω² z = φᵀ g, solved exactly over each step, mode by mode.

    For linear models only, q = sum of φ z; under-, critically and over-damped, free and unstable
    modes alike, and stable for any step where the model is. Between the times of the steps the load
    is held at the value given for the step ("constant"), or goes straight from the last value
    to the one given ("linear"), which then is that at the end of the step.

    Args:
        model: what moves, of r coordinates and of the kind "linear".
        step: time step h [s].
        damping: Rayleigh's (alpha [1/s], beta [s]); the model's own if not given.
        hold: how the load goes on between steps.
        q: coordinates at time zero (r,) or (b, r); rest if not given.
        v: velocities, likewise.
        load: generalised force at time zero, likewise: where a "linear" load begins.
        batch: number b of bodies; by default what the arrays tell, and one body otherwise.

    Raises:
        LoadError: damping, hold or arrays out of range.
        SolverError: the model is not linear, or its mass is not positive definite.
        StepSizeError: the step is not positive and finite.

    References: James and Pai, DyRT, ACM Trans. Graph. 21(3), 2002, for the use of such filters.
    """

    def __init__(
        self,
        model: MotionModel,
        *,
        step: float,
        damping: tuple[float, float] | None = None,
        hold: Literal["constant", "linear"] = "constant",
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        load: ArrayLike | None = None,
        batch: int | None = None,
    ) -> None:
        if model.law.kind != "linear":
            raise SolverError(
                f"ModalFilter needs a model whose force is 'linear', got {model.law.kind!r}; "
                "take ImplicitNewmark for it, or reduce with force='linear'"
            )
        if hold not in ("constant", "linear"):
            raise LoadError(f"hold must be 'constant' or 'linear', got {hold!r}")
        setting = check_setting(model, step=step, damping=damping, q=q, v=v, load=load, batch=batch)
        self.model, self.step, self.damping, self.hold = model, setting.step, setting.damping, hold
        self._shape = setting.shape
        inertia = Inertia(model.mass, setting.shape)
        squares, self._modes = _modes(model, inertia)
        # Rows times these: from forces to modal forces, from coordinates to modal ones, and back.
        self._to_modal = None if self._modes is None else inertia.matrix @ self._modes
        self._lay_out(squares)
        #: Number of steps done.
        self.steps = 0
        load = self._modal_force(setting.load).ravel()
        motion = np.array([self._modal(setting.q).ravel(), self._modal(setting.v).ravel()])
        self._rows[0] = *(motion - self._ahead * load), load

    def _lay_out(self, squares: Array) -> None:
        """Coefficients of all modes of all bodies in one row.

        The exact step is s' = E s + a p + b p' with states s = (z, v), the load p at its start and
        p' at its end; s - b p then obeys s' = E s + (E b + a) p, which needs one load a step, as it
        is with a load that is held.
        """
        alpha, beta = self.damping
        drag = alpha + beta * squares
        response = modal_response(squares, drag, self.step)

        def all_(values: Array) -> Array:
            return np.broadcast_to(values, self._shape).ravel()

        self._stiffness, self._drag = all_(squares), all_(drag)
        zz, zv = all_(response.z_of_z), all_(response.z_of_v)
        vz, vv = all_(response.v_of_z), all_(response.v_of_v)
        step_effect = np.array([all_(response.z_of_load), all_(response.v_of_load)])
        ramp = np.array([all_(response.z_of_ramp), all_(response.v_of_ramp)])
        transition = np.array([[zz, zv], [vz, vv]])
        self._ahead = np.zeros_like(ramp)
        effect = step_effect
        if self.hold == "linear":
            self._ahead = ramp
            effect = np.einsum("ijn,jn->in", transition, ramp) + step_effect - ramp
        n = zz.size
        self._blocks = FilterBlocks(transition, effect)
        self._table = np.concatenate([transition, effect[:, None]], axis=1)  # (2, 3, n)
        self._products = np.empty_like(self._table)
        # Rows z, v, p, twice: the last good ones stay while a step fails.
        self._rows, self._at = np.zeros((2, 3, n)), 0
        self._acting = np.zeros((3, n))

    @property
    def _state(self) -> Array:
        return np.asarray(self._rows[self._at, :2])

    @property
    def _load(self) -> Array:
        return np.asarray(self._rows[self._at, 2])

    @property
    def time(self) -> float:
        """Time [s]."""
        return self.steps * self.step

    @property
    def load_time(self) -> float:
        """Time [s] whose load the next `advance` takes: a held one acts from now on."""
        return (self.steps + (self.hold == "linear")) * self.step

    @property
    def q(self) -> Array:
        """Coordinates, a copy of the shape (r,) or (b, r)."""
        return self._plain((self._state + self._ahead * self._load)[0])

    @property
    def v(self) -> Array:
        """Velocities, likewise [1/s]."""
        return self._plain((self._state + self._ahead * self._load)[1])

    @property
    def a(self) -> Array:
        """Accelerations under the last load, likewise [1/s²]."""
        z, v = self._state + self._ahead * self._load
        return self._plain(self._load - self._drag * v - self._stiffness * z)

    @property
    def frequencies(self) -> Array:
        """Frequencies (r,) [Hz], ascending; NaN of unstable modes."""
        squares = np.sort(self._stiffness[: self._shape[-1]])
        return np.sqrt(np.where(squares >= 0.0, squares, np.nan)) / (2.0 * np.pi)

    def advance(self, load: Array | None = None) -> None:
        """Do one step.

        Args:
            load: generalised force (r,) or (b, r); None for none.

        Raises:
            DivergenceError: numbers became infinite; the last good state stands.
            LoadError: a load of another shape.
        """
        now, then = self._rows[self._at], self._rows[1 - self._at]
        force: Array | float = 0.0
        if load is not None:
            if load.__class__ is not np.ndarray or load.shape != self._shape:
                load = self._checked(load)
            force = self._modal_force(load).reshape(-1)
        acting = self._acting
        acting[...] = now
        if self.hold == "constant":
            acting[2] = force
        np.multiply(self._table, acting, self._products)
        np.add.reduce(self._products, 1, out=then[:2])
        then[2] = force
        flat = then.reshape(-1)
        if not flat.dot(flat) < math.inf:
            raise self._divergence(0)
        self._at = 1 - self._at
        self.steps += 1

    def run(self, loads: ArrayLike, *, out: Array | None = None) -> Array:
        """Do t steps at once, many times faster than one by one.

        Args:
            loads: generalised forces (t, r) or (t, b, r), one a step.
            out: takes the answer; a contiguous array of the shape of ``loads``, not itself.

        Returns:
            coordinates after each step, of the shape of ``loads``.

        Raises:
            DivergenceError: numbers became infinite; the state before the first step stands.
            LoadError: arrays of another shape.
        """
        given = np.ascontiguousarray(loads, dtype=np.float64)
        if given.shape[1:] != self._shape:
            wanted = ", ".join(map(str, self._shape))
            raise LoadError(
                f"loads of t steps must have the shape (t, {wanted}), got {given.shape}"
            )
        if out is None:
            out = np.empty(given.shape)
        elif not (
            out.shape == given.shape
            and out.dtype == np.float64
            and out.flags.c_contiguous
            and not np.may_share_memory(out, given)
        ):
            raise LoadError(
                f"out must be a contiguous array of 64-bit floats of the shape {given.shape}, "
                f"apart from the loads, got {out.dtype} of the shape {out.shape}"
            )
        n = self._stiffness.size
        rows, found = given.reshape(-1, n), out.reshape(-1, n)
        state, last = self._state.copy(), self._load.copy()
        for begin in range(0, len(rows), self._blocks.chunk):
            part = slice(begin, begin + self._blocks.chunk)
            state, last = self._run_chunk(rows[part], state, last, found[part])
        if not np.isfinite(np.vdot(state, state) + np.vdot(last, last)):
            raise self._divergence(int(np.argmin(np.isfinite(rows).all(axis=1))))
        self._rows[self._at] = *state, last
        self.steps += len(rows)
        return out

    def _run_chunk(
        self, loads: Array, state: Array, last: Array, out: Array
    ) -> tuple[Array, Array]:
        force, z = loads, out
        if self._modes is not None:
            shape = (-1, self._shape[-1])
            force, z = (
                (loads.reshape(shape) @ self._modes).reshape(loads.shape),
                np.empty(out.shape),
            )
        if self.hold == "constant":
            state = self._blocks.run(force, state, z)
        else:
            state = self._blocks.run(last[None], state, z[:1])
            state = self._blocks.run(force[:-1], state, z[1:])
            for begin in range(0, len(z), _ROWS):  # few enough to stay in the cache
                part = slice(begin, begin + _ROWS)
                z[part] += self._ahead[0] * force[part]
        if self._modes is not None:
            np.dot(z.reshape(shape), self._modes.T, out.reshape(shape))
        return state, force[-1].copy()

    def _modal_force(self, force: Array) -> Array:
        return force if self._modes is None else force @ self._modes

    def _modal(self, coordinates: Array) -> Array:
        return coordinates if self._to_modal is None else coordinates @ self._to_modal

    def _plain(self, modal: Array) -> Array:
        rows = modal.reshape(self._shape)
        return rows.copy() if self._modes is None else rows @ self._modes.T

    def _checked(self, given: ArrayLike) -> Array:
        values = np.asarray(given, dtype=np.float64)
        if values.shape not in (self._shape, self._shape[-1:]):
            raise LoadError(f"a load must have the shape {self._shape}, got {values.shape}")
        return np.broadcast_to(values, self._shape)

    def _divergence(self, steps: int) -> DivergenceError:
        time = self.time + steps * self.step
        reason = "a load is not finite, or a mode without restoring force grew without bound"
        return DivergenceError(
            f"no step of {self.step:.6g} s was found at {time:.6g} s: {reason}. The state at "
            f"{self.time:.6g} s stands",
            time=self.time,
            step=self.step,
            reason=reason,
        )


def _modes(model: MotionModel, inertia: Inertia) -> tuple[Array, Array | None]:
    """ω² (r,) and φ (r, r) of K φ = ω² M φ with φᵀ M φ = 1; no φ where M and K are diagonal."""
    rest = np.zeros(model.size)
    stiffness = np.array(model.law.evaluator(rest.shape).force_and_stiffness(rest)[1])
    diagonal = np.diagonal(stiffness)
    if inertia.is_identity and not np.any(stiffness - np.diag(diagonal)):
        return diagonal.copy(), None
    half = np.linalg.solve(inertia.factor, stiffness)
    squares, vectors = np.linalg.eigh(np.linalg.solve(inertia.factor, half.T))
    return squares, np.linalg.solve(inertia.factor.T, vectors)
