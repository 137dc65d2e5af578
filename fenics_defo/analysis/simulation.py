"""A body in motion, or on its way through equilibria: one step at a time."""

import math
from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.analysis.energy_watch import EnergyWatch
from fenics_defo.analysis.implicit_step import NewtonSettings
from fenics_defo.analysis.initial import Initial
from fenics_defo.analysis.instant import Instant, StepFailure
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.integrators.quasi_static import QuasiStatic
from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.probes import Probes
from fenics_defo.analysis.readings import energies_of, fields_of, momenta_of, reactions_of
from fenics_defo.analysis.requests import check_request
from fenics_defo.analysis.states import Energies, State, StepReport, Substep
from fenics_defo.analysis.step_limit import StepLimit
from fenics_defo.analysis.substeps import run_substeps
from fenics_defo.analysis.supports import check_supported
from fenics_defo.analysis.system import System, SystemSettings
from fenics_defo.analysis.work import Work
from fenics_defo.errors import DivergenceError, LoadError
from fenics_defo.fem import Solid
from fenics_defo.fem.linear_solvers import Kind

Array = NDArray[np.float64]

# Explicit steps after which it is looked at whether the user's own energy is a number.
_ENERGY_EVERY = 8


class Simulation:
    """Motion of a body under loads, M a + C v + f(u) = g(t, u), step by step.

    C = alpha M + beta K(u) is Rayleigh's damping with the current tangent. Everything is collective
    on ``solid.comm``. Use it in a ``with`` statement, or `close` it.

    Args:
        solid: body.
        loads: what acts on it.
        integrator: `ImplicitNewmark`, `BackwardEuler`, `CentralDifferences`, `SymplecticEuler`, or
            `QuasiStatic`.
        step: time step [s].
        damping: (alpha [1/s], beta [s]).
        newton: number of Newton iterations a step; 1 is semi-implicit: one linearised solve a step,
            whose residual is reported, not judged. None iterates until ``newton_tolerance`` is met.
        newton_tolerance: of converged Newton: largest ‖r‖ / max(‖M a‖, ‖C v‖, ‖f‖, ‖g‖) [-].
        newton_iterations: most iterations of converged Newton with full steps; the search that
            is tried after them may take three times as many.
        linear: solver of the linear systems: "cholesky", "pcg-jacobi" or "pcg-amg".
        linear_tolerance: relative residual of conjugate gradients [-].
        initial: displacement and velocity at time zero.
        prescribed: displacements prescribed in time.
        probes: points at rest [m] by name; `probe` gives their displacements.
        max_halvings: how often a failed step may be halved.
        allow_unstable: go on where an explicit method's step is beyond its limit.
        phases: stopwatch of "tangent" (with the force there), "residual" (forces alone, and the
            products with mass and damping), "factorise" (or what prepares conjugate
            gradients) and "solve".

    Raises:
        LoadError: loads or prescribed motions that this body cannot take.
        StepSizeError: a step that is not positive, or beyond an explicit method's limit.
        SelectionError: a region that the mesh does not have.
        SolverError: nothing holds the body and equilibria are asked for.
    """

    def __init__(
        self,
        solid: Solid,
        loads: Sequence[Load],
        integrator: Integrator,
        *,
        step: float,
        damping: tuple[float, float] = (0.0, 0.0),
        newton: int | None = 1,
        newton_tolerance: float = 1e-6,
        newton_iterations: int = 20,
        linear: Kind = "cholesky",
        linear_tolerance: float = 1e-6,
        initial: Initial | None = None,
        prescribed: Sequence[Prescribed] = (),
        probes: Mapping[str, ArrayLike] | None = None,
        max_halvings: int = 6,
        allow_unstable: bool = False,
        phases: Phases | None = None,
    ) -> None:
        newton_settings = NewtonSettings(newton, newton_tolerance, newton_iterations)
        check_request(integrator, step, damping, newton_settings, max_halvings)
        settings = SystemSettings(
            damping=(float(damping[0]), float(damping[1])),
            newton=newton_settings,
            linear=linear,
            linear_tolerance=linear_tolerance,
            explicit=integrator.explicit,
        )
        self.solid = solid
        self.integrator = integrator
        self.step = float(step)
        self._halvings = max_halvings
        self._system = System(solid, loads, prescribed, settings, phases=phases)
        self._limit = StepLimit(self._system, integrator, self.step, allow_unstable=allow_unstable)
        self._watch: EnergyWatch | None = None
        self._energies: tuple[Instant, Energies] | None = None
        if isinstance(integrator, QuasiStatic):
            check_supported(solid, self._system.constraints.bound)
        self._probes = Probes(solid, probes or {})
        self._work = Work(self._system, integrator.end_weight)
        self._origin, self._steps, self._since_origin = 0.0, 0, 0
        self._is_asked = False
        self._now = self._begin(initial or Initial())
        self._limit.check(self._now)

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self._now.time

    @property
    def steps(self) -> int:
        """Number of whole steps done since time zero."""
        return self._steps

    @property
    def critical_step(self) -> float:
        """Largest stable step of an explicit method [s], when last looked at; infinite for others.

        Collective at first.
        """
        return self._limit.at(self._now)

    @property
    def state(self) -> State:
        """The last good state; collective."""
        gather, now = self.solid.nodes.gather, self._now
        return State(
            time=now.time,
            step=self._steps,
            displacement=gather(now.displacement),
            velocity=gather(now.velocity),
            acceleration=gather(now.acceleration),
        )

    @property
    def energies(self) -> Energies:
        """Energies of the last good state; collective, assembles the strain energy.

        Who asks after each step has the balance looked at after each, see `energy_error`.
        """
        self._is_asked = True
        return self._energies_now()

    @property
    def energy_error(self) -> float | None:
        """Largest error of the energy balance so far over all energy put in [-]; collective.

        Of kinetic + strain + dissipated - external since the start or `restore`, gained or lost,
        over the energy at the start and the largest work done since, see `EnergyWatch`. Looked at
        now, and every few steps before. None for equilibria, which have no motion.
        """
        watch = self._watched()
        if watch is not None:
            watch.look(self._now, self._energies_now())
        return None if watch is None else watch.error

    @property
    def energy_gain(self) -> float | None:
        """As `energy_error`, of what was gained, even if damping took it again; collective."""
        return None if self.energy_error is None or self._watch is None else self._watch.gain

    def check_energy(self) -> None:
        """Look at the energy balance now, which `advance` does every few steps; collective.

        Raises:
            DivergenceError: the energy has run away, or is no number.
        """
        watch = self._watched()
        if watch is not None:
            watch.judge(
                self._now,
                self._energies_now(),
                limit=self._limit.at(self._now),
                lenient=self._limit.allow_unstable,
            )

    def _watched(self) -> EnergyWatch | None:
        if isinstance(self.integrator, QuasiStatic):
            return None
        if self._watch is None:
            self._watch = EnergyWatch(
                self._system,
                self.integrator,
                step=self.step,
                start=self._now,
                energies=self._energies_now(),
                work=self._work,
            )
        return self._watch

    def _energies_now(self) -> Energies:
        if self._energies is None or self._energies[0] is not self._now:
            self._energies = (self._now, energies_of(self._system, self._now, self._work))
        return self._energies[1]

    def is_definite(self) -> bool | None:
        """Whether the tangent of the loads and forces at the last good state is positive definite.

        None if the linear solver cannot tell, or a law's tangent is "definite" or "approximate";
        collective, factorises it.
        """
        return self._system.is_definite(self._now)

    @property
    def probe_names(self) -> tuple[str, ...]:
        """Names of the probes in the order given."""
        return self._probes.names

    def probe(self, name: str) -> Array:
        """Displacement (3,) [m] of a probe; collective.

        Raises:
            LoadError: there is no such probe.
        """
        return self._probes.value(name, self._now.displacement)

    def momentum(self) -> tuple[Array, Array]:
        """Momentum (3,) [kg m/s] and angular momentum (3,) about the origin [kg m²/s]; collective.

        The mass is the integrator's, consistent or lumped.
        """
        return momenta_of(self._system, self._now)

    def reactions(self) -> Array:
        """Forces (n, 3) [N] of supports and of what prescribes motions upon the body; collective.

        M a + C v + f - g at components that are not free; zero at others.
        """
        return reactions_of(self._system, self._now)

    def advance(self) -> StepReport:
        """Do one step.

        Returns:
            how it went.

        Raises:
            DivergenceError: it failed however often it was halved, or the energy has run away (see
                `EnergyWatch`); the last good state, maybe part of a step on, stands.
            StepSizeError: an explicit method's limit has fallen below the step.
        """
        self._limit.check_now_and_then(self._now, self._since_origin)
        watch, good = self._watched(), (self._now, self._work.external, self._work.dissipated)
        system = self._system
        system.reset_counters()
        self._substeps: list[Substep] = []
        end = self._origin + (self._since_origin + 1) * self.step
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            start = self._struck(self._now, end)
            halvings = run_substeps(
                start, end, advance=self._substep, keep=self._keep, most=self._halvings
            )
        if watch is not None and (self._is_asked or watch.is_due(self._since_origin + 1)):
            self._is_asked = False
            try:
                self.check_energy()
            except DivergenceError:
                self._now, self._work.external, self._work.dissipated = good
                raise
        self._steps += 1
        self._since_origin += 1
        return StepReport(
            time=self._now.time,
            step=self._steps,
            newton_iterations=system.newton_iterations,
            linear_iterations=system.linear_iterations,
            halvings=halvings,
            substeps=tuple(self._substeps),
        )

    def restore(self, state: State, energies: Energies) -> None:
        """Go on from a state that this simulation, or another of the same kind, gave out.

        With the direct solver the numbers that follow are those of the uninterrupted run, bit by
        bit on the same number of ranks.

        Args:
            state: where to go on.
            energies: those of the same time.

        Raises:
            LoadError: arrays of another shape, or not finite.
        """
        fields = [self._own(field) for field in fields_of(state, self.solid.nodes.size)]
        self._now = Instant(float(state.time), *fields)
        self._steps, self._origin, self._since_origin = state.step, float(state.time), 0
        if math.isclose(state.time, state.step * self.step, rel_tol=1e-12):
            # On this simulation's own grid of times: they are to be the same numbers again.
            self._origin, self._since_origin = 0.0, state.step
        self._work.external, self._work.dissipated = energies.external, energies.dissipated
        self._watch = self._energies = None
        self._limit.check(self._now)

    def close(self) -> None:
        """Free the matrices and the solver; collective."""
        self._system.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _begin(self, initial: Initial) -> Instant:
        """The motion at time zero, with the acceleration that the forces there give."""
        system = self._system
        u, v = (self._own(field) for field in initial.fields(self.solid.nodes.size))
        u, v = np.where(self._held(), 0.0, u), np.where(self._held(), 0.0, v)
        u = system.with_prescribed(0.0, u)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            now = system.instant(0.0, self.step, u, v, np.zeros_like(u))
            if isinstance(self.integrator, QuasiStatic):
                return now
            try:
                if not system.has_energy(u):
                    raise StepFailure("the strain energy is infinite or no number")
                return system.free_acceleration(now)
            except StepFailure as failure:
                raise LoadError(
                    f"the motion cannot begin: {failure.reason}; check the initial displacement "
                    "and the loads at time zero"
                ) from failure

    def _held(self) -> NDArray[np.bool_]:
        constraints = self._system.constraints
        return ~constraints.free & ~constraints.prescribed

    def _own(self, field: Array) -> Array:
        return self.solid.nodes.scatter(field)[: self.solid.nodes.owned].copy()

    def _struck(self, start: Instant, end: float) -> Instant:
        """The motion after the impulses of a step, which act at its start."""
        system, tiny = self._system, 1e-9 * self.step
        for impulse, momentum in system.loads.impulses:
            if not start.time - tiny <= impulse.time < end - tiny:
                continue
            change = system.mass.solve(momentum, system.free)
            before, after = start.velocity, start.velocity + change
            self._work.add_blow(np.where(system.free, momentum, 0.0), before, after)
            start = Instant(start.time, start.displacement, after, start.acceleration)
            if any(system.settings.damping) and not isinstance(self.integrator, QuasiStatic):
                start = system.free_acceleration(start)
                if self._watch is not None:
                    self._watch.add_hidden(start)
        return start

    def _substep(self, start: Instant, length: float) -> Instant:
        system = self._system
        self._before = system.forces(start)
        reached = self.integrator.advance(system, start, length)
        after = system.forces(reached)
        finite = system.is_finite(after.internal)
        if not (finite and (not system.is_damped or system.is_finite(after.damping))):
            raise StepFailure("the forces became infinite or no number", system.residuals)
        looks = not self.integrator.explicit or self._since_origin % _ENERGY_EVERY == 0
        if looks and not system.has_energy(reached.displacement):
            raise StepFailure("the strain energy became infinite or no number", system.residuals)
        self._limit.check_growth(start, reached, self._before, after, self._since_origin)
        return reached

    def _keep(self, start: Instant, reached: Instant) -> None:
        self._work.add_step(start, reached, self._before, self._system.forces(reached))
        residuals = () if self.integrator.explicit else self._system.residuals
        self._substeps.append(Substep(reached.time, residuals))
        self._now = reached
