"""One implicit step: Newton's method for the displacement at its end."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.instant import Instant, Rule, StepFailure
from fenics_defo.analysis.line_search import flatter
from fenics_defo.errors import SolverError

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
# What the forces at the start of the step leave as round-off in those at its end.
_START_ROUND_OFF = 1e3 * _EPS
# Forces of round-off in the displacements that count as none, in units of eps K (|u| + cell).
_ROUND_OFF = 10.0
# A residual that grows beyond this multiple of the first will not come back.
_HOPELESS = 1e10
_CUTS = 12
# A search may take so many times as many iterations: far from a solution, or with a definite matrix
# for an indefinite derivative, they gain a digit in three or four.
_PATIENCE = 3
# Convergence slower than this is worth another tangent, which knows how the damping changes.
_SLOW = 0.1
# What an indefinite matrix is stiffened by first, as a part of its diagonal, and how much more.
_STIFFEN, _STIFFEN_MORE, _STIFFENINGS = 0.1, 4.0, 8


@dataclass(frozen=True, slots=True)
class NewtonSettings:
    """How Newton's method ends.

    Args:
        iterations: solves a step; None: until ``tolerance`` is met.
        tolerance: largest ‖r‖ / max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖), with r = M a + C v + f - g at free
            components and the forces at all.
        most: largest number of solves.
    """

    iterations: int | None
    tolerance: float
    most: int


@dataclass(frozen=True, slots=True)
class _Balance:
    """Motion and forces at an iterate.

    Args:
        velocity: (owned nodes, 3) [m/s].
        acceleration: (owned nodes, 3) [m/s²].
        internal: (owned nodes, 3) [N].
        external: (owned nodes, 3) [N].
        damping: (owned nodes, 3) [N].
        residual: (owned nodes, 3) [N], zero where not free.
        size: ‖residual‖ [N].
        scale: largest norm of the terms [N].
    """

    velocity: Array
    acceleration: Array
    internal: Array
    external: Array
    damping: Array
    residual: Array
    size: float
    scale: float


@dataclass(frozen=True, slots=True)
class _Way:
    """How Newton's method goes about a step.

    Args:
        search: along directions of descent, instead of full steps.
        ahead: with β K'(u) v in the matrix as soon as convergence is slow.
    """

    search: bool
    ahead: bool


class ImplicitStep:
    """The equations at the end of one step, with the displacement there unknown; collective.

    Newton starts from the displacement at the start of the step, where no cell is more distorted
    than the last step left it; what is prescribed moves in the first solve, by its columns of K.

    Args:
        system: body, loads and constraints.
        start: motion at the start.
        step: [s].
        rule: the integrator's.
    """

    def __init__(self, system: "System", start: Instant, step: float, rule: Rule) -> None:
        self._system = system
        self._start = start
        self._rule = rule
        self._time = start.time + step
        constraints = system.constraints
        self._rates = constraints.rates(self._time, step) if constraints.moving else None
        if not rule.acceleration_rate > 0.0:
            self._rates = None  # without inertia, nothing has a rate
        self._first_scale = 0.0
        self._stiffening = 0.0
        self._is_slow = False
        self._to_come = constraints.moving  # whether what is prescribed is still where it was

    def run(self) -> Instant:
        """The motion at the end.

        Raises:
            StepFailure: it was not found.
        """
        residuals: list[float] = []
        ways = self._ways()
        try:
            for way in ways:
                residuals.clear()
                try:
                    return self._newton(residuals, way)
                except StepFailure as failure:
                    if way is ways[-1] or failure.lasting:
                        raise StepFailure(
                            failure.reason, tuple(residuals), lasting=failure.lasting
                        ) from failure
            raise AssertionError("there is a last way")
        finally:
            self._system.residuals = tuple(residuals)

    def _ways(self) -> tuple[_Way, ...]:
        """Ways to iterate, one tried after the other has failed.

        Bending wants full steps, compression a search. The change of the damping's stiffness makes
        Newton's order quadratic again, and where that stiffness is indefinite, the matrix too.
        """
        system = self._system
        if system.settings.newton.iterations is not None:
            return (_Way(search=False, ahead=False),)
        plain, searching = _Way(search=False, ahead=False), _Way(search=True, ahead=False)
        if not system.damping_changes:
            return plain, searching
        return _Way(search=False, ahead=True), plain, searching

    def _newton(self, residuals: list[float], way: _Way) -> Instant:
        system, newton = self._system, self._system.settings.newton
        u, self._to_come = self._start.displacement, system.constraints.moving
        system.linearise(u)
        balance = self._balance(u)
        self._first_scale = balance.scale
        residuals.append(_ratio(balance.size, balance.scale))
        most = newton.most if newton.iterations is None else newton.iterations
        most *= _PATIENCE if way.search else 1
        self._is_slow = False
        for iteration in range(most):
            if newton.iterations is None and iteration and self._is_solved(u, balance):
                return self._end(u, balance)
            if way.search and not self._to_come:
                u = self._searched(u, balance)
            else:
                u = self._stepped(u, self._direction(u, balance))
            system.linearise(u)
            before, balance = balance.size, self._balance(u)
            self._is_slow = way.ahead and (self._is_slow or balance.size > _SLOW * before)
            residuals.append(_ratio(balance.size, balance.scale))
            if not balance.size <= _HOPELESS * max(self._first_scale, balance.scale):
                raise StepFailure("the residual grew without bound or is no number")
        if newton.iterations is None and not self._is_solved(u, balance):
            raise StepFailure(f"Newton's method did not converge in {most} iterations")
        if self._to_come:
            raise StepFailure("what is prescribed leads to infinite forces or energy")
        return self._end(u, balance)

    def _balance(self, u: Array) -> _Balance:
        """Motion and forces at ``u``; β K v with the tangent as it is filled."""
        with self._system.phases("residual"):
            return self._forces_at(u)

    def _forces_at(self, u: Array) -> _Balance:
        system, rule = self._system, self._rule
        change = u - self._start.displacement
        v = rule.velocity + rule.velocity_rate * change
        a = rule.acceleration + rule.acceleration_rate * change
        if self._rates is not None:
            at = system.constraints.prescribed
            v[at], a[at] = self._rates
        internal = system.internal_force(u)
        external = system.external_force(self._time, u)
        damping = self._damping(u, v)
        residual = damping + internal
        residual -= external
        inertia = system.mass.apply(a) if rule.acceleration_rate > 0.0 else None
        if inertia is not None:
            residual += inertia
        residual *= system.free
        terms = (internal, external, damping, *(() if inertia is None else (inertia,)))
        size, *norms = np.sqrt(self._squares(residual, *terms))
        return _Balance(
            v, a, internal, external, damping, residual, float(size), float(np.max(norms))
        )

    def _damping(self, u: Array, v: Array) -> Array:
        system, part = self._system, self._rule.velocity_part
        if u is self._start.displacement and part is not None and self._rates is None:
            return part * system.forces(self._start).damping
        damping, beta = system.mass_damping(v), system.settings.damping[1]
        return damping + beta * system.tangents.stiffness_times(v) if beta else damping

    def _squares(self, *fields: Array) -> Array:
        own = np.array([np.vdot(field, field) for field in fields])
        return np.asarray(self._system.comm.allreduce(own))

    def _is_solved(self, u: Array, balance: _Balance) -> bool:
        if self._to_come:
            return False
        tolerance = self._system.settings.newton.tolerance
        allowed = max(tolerance * balance.scale, _START_ROUND_OFF * self._first_scale)
        return balance.size <= allowed or balance.size <= self._round_off(u)

    def _round_off(self, u: Array) -> float:
        """Residual [N] that rounding u and the deformation gradient leaves."""
        system = self._system
        cells = system.solid.mesh_data.mesh.topology.index_map(3).size_global
        cell = system.size / cells ** (1.0 / 3.0)
        diagonal = system.tangents.diagonal() * system.free
        return _ROUND_OFF * _EPS * system.norm(diagonal * (np.abs(u) + cell))

    def _direction(self, u: Array, balance: _Balance, *, stiffening: float = 0.0) -> Array:
        """Solve for the change of the displacement."""
        system, rule = self._system, self._rule
        right_side, change = -balance.residual, None
        if self._to_come:
            change = np.zeros_like(u)
            at = system.constraints.prescribed
            change[at] = system.constraints.displacement(self._time) - u[at]
            # Their velocities and accelerations are known already: only f is to follow.
            right_side -= np.where(system.free, system.tangents.stiffness_times(change), 0.0)
        alpha, beta = system.settings.damping
        mass_scale = rule.acceleration_rate + alpha * rule.velocity_rate
        scale = 1.0 + beta * rule.velocity_rate
        follows = system.loads.follows
        local = system.local(u) if follows else u
        system.newton_iterations += 1
        try:
            with system.phases("factorise"):
                system.tangents.prepare(
                    scale,
                    mass_scale,
                    system.loads,
                    self._time,
                    local,
                    ahead=system.ahead(u, balance.velocity) if self._is_slow else None,
                    stiffening=stiffening,
                )
            with system.phases("solve"):
                if follows and system.settings.newton.iterations is None:
                    direction, iterations = system.tangents.solve_unsymmetric(
                        right_side, system.loads, self._time, local
                    )
                else:
                    direction, iterations = system.tangents.solve(right_side)
        except SolverError as error:
            # In statics the tangent at the start is that of any part of the load.
            lasting = u is self._start.displacement and not rule.acceleration_rate > 0.0
            raise StepFailure(str(error), lasting=lasting) from error
        system.linear_iterations += iterations
        return direction if change is None else direction + change

    def _stepped(self, u: Array, direction: Array) -> Array:
        """The next iterate: a full step, or less where that leads to infinity."""
        system, length = self._system, 1.0
        for _ in range(_CUTS):
            trial = u + length * direction
            if self._to_come and length == 1.0:  # without the round-off of the sum
                system.with_prescribed(self._time, trial)
            if system.is_finite(system.linearise(trial)) and system.has_energy(trial):
                self._to_come = self._to_come and length < 1.0
                return trial
            length *= 0.5
        raise StepFailure("no step along Newton's direction leads to finite forces and energy")

    def _searched(self, u: Array, balance: _Balance) -> Array:
        """The next iterate along a direction of descent, where the residual is orthogonal to it.

        That is the least potential along it, if there is one.
        """
        system = self._system
        direction = self._downhill(u, balance)

        def slope_at(length: float) -> float:
            trial = u + length * direction
            if not (system.is_finite(system.internal_force(trial)) and system.has_energy(trial)):
                return math.inf
            return system.product(direction, self._balance(trial).residual)

        length = flatter(system.product(direction, balance.residual), slope_at)
        if length is None:
            raise StepFailure("no step along Newton's direction leads to smaller forces")
        return u + length * direction

    def _downhill(self, u: Array, balance: _Balance) -> Array:
        """A direction of descent, of a matrix that is stiffened until it is definite."""
        system, stiffening = self._system, self._stiffening
        for trial in range(_STIFFENINGS):
            try:
                direction = self._direction(u, balance, stiffening=stiffening)
            except StepFailure as failure:  # what conjugate gradients say of such a matrix
                if failure.lasting or trial == _STIFFENINGS - 1:
                    raise
            else:
                descends = system.product(direction, balance.residual) < 0.0
                if descends and system.tangents.definite is not False:
                    break
            stiffening = max(_STIFFEN_MORE * stiffening, _STIFFEN)
        self._stiffening = stiffening / _STIFFEN_MORE if stiffening > _STIFFEN else 0.0
        return direction

    def _end(self, u: Array, balance: _Balance) -> Instant:
        system = self._system
        if not (math.isfinite(balance.size) and system.is_finite(u)):
            raise StepFailure("the displacements or forces became infinite or no number")
        instant = Instant(self._time, u, balance.velocity, balance.acceleration)
        system.remember(instant, balance.internal, balance.external, balance.damping)
        return instant


def _ratio(size: float, scale: float) -> float:
    return size / scale if scale > 0.0 else size
