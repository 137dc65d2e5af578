"""The equations of motion of a body over this rank's own nodes, M a + C v + f(u) = g(t, u)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.applied_loads import AppliedLoads
from fenics_defo.analysis.constraints import Constraints
from fenics_defo.analysis.implicit_step import ImplicitStep, NewtonSettings
from fenics_defo.analysis.inertia_operators import ConsistentMassOperator, LumpedMass, Mass
from fenics_defo.analysis.instant import Forces, Instant, Rule, StepFailure
from fenics_defo.analysis.known_laws import has_exact_tangents, has_finite_energy
from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.tangents import Ahead, Tangents
from fenics_defo.errors import SolverError
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import MPI, dolfinx
from fenics_defo.fem.linear_solvers import Kind

Array = NDArray[np.float64]

# Part of the body's size that the difference quotient along a velocity goes: the root of the
# round-off balances its two errors.
_DIFFERENCE = float(np.sqrt(np.finfo(float).eps))


@dataclass(frozen=True, slots=True)
class SystemSettings:
    """How the equations are written and solved.

    Args:
        damping: Rayleigh's (alpha [1/s], beta [s]).
        newton: Newton's method.
        linear: linear solver.
        linear_tolerance: relative residual of conjugate gradients.
        explicit: whether the mass is lumped and no matrix is needed.
    """

    damping: tuple[float, float]
    newton: NewtonSettings
    linear: Kind
    linear_tolerance: float
    explicit: bool


class System:
    """A body, its loads and its constraints, ready to be integrated; collective.

    Fields are arrays (owned nodes, 3), never written to once they are in an `Instant`: forces and
    tangents that belong to one are known by it.

    Args:
        solid: body.
        loads: what acts on it.
        prescribed: prescribed motions.
        settings: how the equations are solved.
        phases: stopwatch of "residual", "tangent", "factorise" and "solve".

    Raises:
        LoadError: loads or prescribed motions that this body cannot take.
        SelectionError: a region that the mesh does not have.
    """

    def __init__(
        self,
        solid: Solid,
        loads: Sequence[Load],
        prescribed: Sequence[Prescribed],
        settings: SystemSettings,
        *,
        phases: Phases | None = None,
    ) -> None:
        self.solid = solid
        self.settings = settings
        self.phases = phases or Phases()
        self.comm = solid.comm
        self.owned = solid.nodes.owned
        self.constraints = Constraints(solid, prescribed)
        self.free = self.constraints.free
        make_mass = LumpedMass if settings.explicit else ConsistentMassOperator
        self.mass: Mass = make_mass(solid.assembly)
        self.loads = AppliedLoads(solid, loads, self.mass)
        self.size = float(np.ptp(solid.points, axis=0).max())
        #: Counters since `reset_counters`.
        self.newton_iterations = self.linear_iterations = 0
        #: Relative residuals of the last implicit step.
        self.residuals: tuple[float, ...] = ()
        #: A field of zeros that nobody writes to.
        self.zero: Array = np.zeros((self.owned, 3))
        self.zero.setflags(write=False)
        self._ghosted = dolfinx.la.vector(solid.space.dofmap.index_map, 3)
        self._internal: tuple[Array, Array] | None = None
        self._strain: tuple[Array, float] | None = None
        self._unsure = not has_finite_energy(solid.materials)
        self._is_exact = has_exact_tangents(solid.materials)
        self._viscous: tuple[Array, Array, Array] | None = None
        self._forces: tuple[Instant, Forces] | None = None

    @cached_property
    def tangents(self) -> Tangents:
        """Matrices, allocated on first use."""
        settings = self.settings
        return Tangents(self.solid, self.constraints, settings.linear, settings.linear_tolerance)

    @property
    def is_damped(self) -> bool:
        """Whether there is any damping."""
        return any(self.settings.damping)

    def reset_counters(self) -> None:
        """Count iterations from zero again."""
        self.newton_iterations = self.linear_iterations = 0

    def close(self) -> None:
        """Free the matrices."""
        if "tangents" in self.__dict__:
            self.tangents.close()

    def local(self, field: Array) -> Array:
        """A field with its ghosts (d, 3); valid until the next call."""
        if self.comm.size == 1:
            return field
        self._ghosted.array[: field.size] = field.ravel()
        self._ghosted.scatter_forward()
        return np.asarray(self._ghosted.array).reshape(-1, 3)

    def product(self, left: Array, right: Array) -> float:
        """Sum of the products of all components on all ranks."""
        return float(self.comm.allreduce(float(np.vdot(left, right))))

    def norm(self, field: Array) -> float:
        """Euclidean norm over all ranks; not finite if any number is not."""
        return float(np.sqrt(self.product(field, field)))

    def is_finite(self, field: Array) -> bool:
        """Whether all numbers on all ranks are finite."""
        return bool(np.isfinite(self.product(field, field)))

    def internal_force(self, displacement: Array) -> Array:
        """f(u), reactions included."""
        if self._internal is None or self._internal[0] is not displacement:
            with self.phases("residual"):
                force = self.solid.assembly.force(self.local(displacement))[: self.owned]
            self._internal = (displacement, force)
        return self._internal[1]

    def strain_energy(self, displacement: Array) -> float:
        """U(u) [J], of the whole body."""
        if self._strain is None or self._strain[0] is not displacement:
            with self.phases("residual"):
                energy = self.solid.assembly.energy(self.local(displacement))
            self._strain = (displacement, energy)
        return self._strain[1]

    def has_energy(self, displacement: Array) -> bool:
        """Whether the energy is a number where the forces are; asked of the user's own laws only.

        A logarithm of det F < 0 is none, and its derivative 1 / det F is finite.
        """
        return not self._unsure or bool(np.isfinite(self.strain_energy(displacement)))

    def external_force(self, time: float, displacement: Array) -> Array:
        """g(t, u)."""
        follows = self.loads.follows  # if not, the ghosts are not needed
        return self.loads.force(time, self.local(displacement) if follows else displacement)

    def mass_damping(self, velocity: Array) -> Array:
        """α M v."""
        alpha = self.settings.damping[0]
        if not alpha:
            return self.zero
        damping = self.mass.apply(velocity)
        damping *= alpha
        return damping

    def linearise(self, displacement: Array) -> Array:
        """Internal force f(u), with the tangent filled there; laws at points give both at once."""
        if self.tangents.filled_at is not displacement:
            with self.phases("tangent"):
                force = self.tangents.fill(displacement, self.local(displacement))[: self.owned]
            self._internal = (displacement, force)
        return self.internal_force(displacement)

    def stiffness_damping(self, displacement: Array, velocity: Array) -> Array:
        """β K(u) v; implicit methods have filled K, explicit ones take a difference of forces."""
        beta = self.settings.damping[1]
        if not beta:
            return self.zero
        if not self.settings.explicit:
            self.linearise(displacement)
            return beta * self.tangents.stiffness_times(velocity)
        known = self._viscous
        if known is None or known[0] is not displacement or known[1] is not velocity:
            force = beta * self._force_along(displacement, velocity)
            known = self._viscous = (displacement, velocity, force)
        return known[2]

    @property
    def damping_changes(self) -> bool:
        """Whether β K(u) changes with u, and K is the derivative of the forces."""
        return bool(self.settings.damping[1] and self._is_exact and not self.solid.is_linear)

    def ahead(self, displacement: Array, velocity: Array) -> Ahead | None:
        """How β K changes along a velocity; None if nothing moves."""
        beta = self.settings.damping[1]
        fastest = self.comm.allreduce(float(np.abs(velocity).max(initial=0.0)), op=MPI.MAX)
        if not fastest > 0.0:
            return None
        step = _DIFFERENCE * self.size / fastest
        return Ahead(self.local(displacement + step * velocity), beta / step)

    def _force_along(self, displacement: Array, velocity: Array) -> Array:
        """K(u) v as (f(u + s v) - f(u)) / s."""
        fastest = float(np.abs(velocity).max(initial=0.0))
        fastest = self.comm.allreduce(fastest, op=MPI.MAX)
        if not fastest > 0.0:
            return np.zeros_like(velocity)
        here = self.internal_force(displacement)
        step = _DIFFERENCE * self.size / fastest
        ahead = self.solid.assembly.force(self.local(displacement + step * velocity))
        return (ahead[: self.owned] - here) / step

    def forces(self, instant: Instant) -> Forces:
        """All forces at an instant; the implicit methods' tangent is filled there, too."""
        if self._forces is not None and self._forces[0] is instant:
            return self._forces[1]
        u, v = instant.displacement, instant.velocity
        if not self.settings.explicit:
            self.linearise(u)
        internal, external = self.internal_force(u), self.external_force(instant.time, u)
        damping = self.zero
        if self.is_damped:
            damping = self.mass_damping(v)
            if self.settings.damping[1]:
                damping = damping + self.stiffness_damping(u, v)
        return self.remember(instant, internal, external, damping)

    def is_definite(self, instant: Instant) -> bool | None:
        """Whether K - dg/du at an instant is positive definite.

        None if the solver cannot tell, or some law puts another matrix in the place of K.
        """
        tangents = self.tangents
        if not (tangents.can_tell and self._is_exact):
            return None
        self.linearise(instant.displacement)
        local = self.local(instant.displacement)
        try:
            tangents.prepare(1.0, 0.0, self.loads, instant.time, local)
        except SolverError:  # singular
            return False
        return tangents.definite

    def remember(
        self, instant: Instant, internal: Array, external: Array, damping: Array
    ) -> Forces:
        """Keep the forces at an instant for those who ask next, with the reactions there."""
        reaction = self.zero
        if self.constraints.moving:
            balance = self.mass.apply(instant.acceleration) + damping + internal - external
            reaction = np.where(self.constraints.prescribed, balance, 0.0)
        forces = Forces(internal, external, damping, reaction)
        self._forces = (instant, forces)
        return forces

    def solve(self, start: Instant, step: float, rule: Rule) -> Instant:
        """The instant ``step`` [s] after ``start`` at which the equations hold.

        Raises:
            StepFailure: none was found.
        """
        return ImplicitStep(self, start, step, rule).run()

    def explicit_acceleration(
        self, time: float, displacement: Array, velocity: Array, *, lag: float
    ) -> Array:
        """M⁻¹ (g - f - β K v) - α (v + lag a), solved for a; zero where not free.

        Args:
            time: [s].
            displacement: (owned nodes, 3) [m].
            velocity: (owned nodes, 3) [m/s].
            lag: how long after ``velocity`` the mass damping takes its own [s].
        """
        alpha = self.settings.damping[0]
        force = self.external_force(time, displacement) - self.internal_force(displacement)
        if self.settings.damping[1]:
            force -= self.stiffness_damping(displacement, velocity)
        acceleration = self.mass.solve(force, self.free)
        if alpha:
            slowing = (-alpha) * velocity
            slowing *= self.free
            acceleration += slowing
            acceleration *= 1.0 / (1.0 + alpha * lag)
        return acceleration

    def free_acceleration(self, instant: Instant) -> Instant:
        """An instant with the acceleration that its forces give the free components."""
        forces = self.forces(instant)
        rest = forces.external - forces.internal - forces.damping
        bound = np.where(self.free, 0.0, instant.acceleration)
        rest -= self.mass.apply(bound)
        acceleration = bound + self.mass.solve(rest, self.free)
        return Instant(instant.time, instant.displacement, instant.velocity, acceleration)

    def with_prescribed(self, time: float, displacement: Array) -> Array:
        """Write the prescribed displacements at ``time`` [s] into a fresh field; returns it."""
        if self.constraints.moving:
            displacement[self.constraints.prescribed] = self.constraints.displacement(time)
        return displacement

    def instant(
        self, time: float, step: float, displacement: Array, velocity: Array, acceleration: Array
    ) -> Instant:
        """An instant of fresh fields, with the prescribed velocities and accelerations.

        Raises:
            StepFailure: a displacement or velocity is not finite.
        """
        if self.constraints.moving:
            at = self.constraints.prescribed
            velocity[at], acceleration[at] = self.constraints.rates(time, step)
        squares = float(np.vdot(velocity, velocity))
        if not self.settings.explicit:  # those of explicit methods come from the velocities
            squares += float(np.vdot(displacement, displacement))
        if not np.isfinite(self.comm.allreduce(squares)):
            raise StepFailure("the displacements or velocities became infinite or no number")
        return Instant(time, displacement, velocity, acceleration)
