"""Whether a motion has more energy than was ever put into it."""

import logging

import numpy as np

from fenics_defo.analysis.instant import Instant
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.states import Energies
from fenics_defo.analysis.system import System
from fenics_defo.analysis.work import Work
from fenics_defo.errors import DivergenceError

_log = logging.getLogger(__name__)

# Excess at which a motion has run away: half of its energy comes from nothing.
_RUNAWAY = 1.0
# Gain that is worth a warning, and loss where the method itself takes nothing.
_NOTABLE = 0.1
# Steps between two looks: the strain energy costs about as much as the forces.
_EVERY = 8
_EVERY_EXPLICIT = 256
# How much of the work of a single step may be an error.
_ROUGH = 4.0
# Energy that counts as none, over that of a body stretched to twice its size: strains of 1e-12.
_NOTHING = 1e-24
# Nearest to its limit that a step of an explicit method is taken to be.
_NEAREST = 0.98


class EnergyWatch:
    """The energy balance of a motion, looked at every few steps; collective.

    With kinetic energy T, strain energy U, work W of loads and prescribed motions, dissipated D,
    and all energy that was ever put in as the scale,

        scale  = T0 + |U0 - U(rest)| + c h² a0·M a0 + max (|W| + h |g·v|) + 4 max |w| + max Tp
        excess = (T + U - T0 - U0 - W) / scale
        gain   = the largest (T + U - T0 - U0 - W + max D) / scale
        error  = the largest |T + U - T0 - U0 - W + D| / scale, or the gain,

    zeroes for the start (and a0 for each blow), maxima over the time since then; c is the method's
    ``hidden_energy``, h |g·v| the work that loads and reactions g would do in a step, by which
    explicit methods and prescribed velocities are late or early, w the work of one step and Tp the
    kinetic energy of prescribed velocities alone, which a sudden motion makes large and hard to
    tell. What is dissipated never comes back: an indefinite stiffness damping, which feeds the
    motion, is a gain.

    A motion whose excess is above 1 holds twice the energy that it can have: it has run away. A
    gain without excess is energy that damping has taken again. It is told, and so are losses where
    the method itself takes nothing.

    Explicit methods keep another energy than T + U. For a vibration at ω = 2 r / h, r < 1, the two
    differ by a factor between 1 - r and 1 + r, so that T + U may grow by 2 r / (1 - r) without
    error; that is allowed them.

    Args:
        system: the equations.
        integrator: method.
        step: its step [s].
        start: motion at the start.
        energies: there.
        work: that of the motion.
    """

    def __init__(
        self,
        system: System,
        integrator: Integrator,
        *,
        step: float,
        start: Instant,
        energies: Energies,
        work: Work,
    ) -> None:
        self._work = work
        self._system, self._integrator, self._step = system, integrator, step
        self._begin = energies.kinetic + energies.strain
        self._external, self._dissipated = energies.external, energies.dissipated
        self._most_dissipated = 0.0
        self._scale = energies.kinetic + abs(energies.strain - self._strain(0.0))
        self.add_hidden(start)
        self._most_work = self._most_driven = 0.0
        doubled = self._strain(1.0)
        self._nothing = _NOTHING * abs(doubled) if np.isfinite(doubled) else 0.0
        self._said = False
        #: Largest |T + U + D - W - its value at the start| / scale so far [-].
        self.error = 0.0
        #: Largest gain so far [-].
        self.gain = 0.0

    def add_hidden(self, start: Instant) -> None:
        """Count what the method adds to T + U at a start, or after a blow."""
        if self._integrator.hidden_energy > 0.0:
            a = start.acceleration
            inertia = self._system.product(a, self._system.mass.apply(a))
            self._scale += self._integrator.hidden_energy * self._step**2 * inertia

    def is_due(self, steps: int) -> bool:
        """Whether to look after so many steps."""
        return steps % (_EVERY_EXPLICIT if self._integrator.explicit else _EVERY) == 0

    def look(self, now: Instant, energies: Energies) -> float:
        """Take note of the energies at an instant; returns the excess there [-]."""
        work = energies.external - self._external
        lost = energies.dissipated - self._dissipated
        self._most_dissipated = max(self._most_dissipated, lost)
        forces = self._system.forces(now)
        power = self._system.product(forces.external + forces.reaction, now.velocity)
        self._most_work = max(self._most_work, abs(work) + self._step * abs(power))
        self._most_driven = max(self._most_driven, self._driven(now))
        change = energies.kinetic + energies.strain - self._begin - work
        put_in = self._scale + self._most_work + _ROUGH * self._work.largest + self._most_driven
        scale = max(put_in, self._nothing)
        if not scale > 0.0:
            return 0.0
        gain = (change + self._most_dissipated) / scale
        self.gain = max(self.gain, gain)
        self.error = max(self.error, abs(change + lost) / scale, gain)
        return change / scale

    def judge(self, now: Instant, energies: Energies, *, limit: float, lenient: bool) -> None:
        """`look`, and say what is wrong.

        Args:
            now: where the motion is.
            energies: there.
            limit: largest stable step of an explicit method [s]; infinite for others.
            lenient: only warn of a runaway.

        Raises:
            DivergenceError: the energy is no number, or has run away.
        """
        if not np.isfinite(energies.balance):
            raise _runaway("the energy is infinite or no number", energies, now.time, self._step)
        near = min(self._step / limit, _NEAREST)
        spare = 2.0 * near / (1.0 - near)
        excess = self.look(now, energies)
        if excess > _RUNAWAY + spare and not lenient:
            reason = f"the motion holds {1.0 + excess:.3g} times all the energy ever put into it"
            raise _runaway(reason, energies, now.time, self._step)
        notable = self.error if self._integrator.keeps_energy else self.gain
        if notable > _NOTABLE + spare and not self._said:
            self._said = True
            _log.warning(
                "by %.6g s the energy balance is wrong by %.2g of all the energy ever put in: "
                "steps of %.3g s are too long for this motion, or one Newton iteration is too few",
                now.time,
                notable,
                self._step,
            )

    def _strain(self, stretch: float) -> float:
        """Strain energy of the body grown by ``stretch`` [J]."""
        solid = self._system.solid
        return solid.assembly.energy(stretch * solid.nodes.scatter(solid.points))

    def _driven(self, now: Instant) -> float:
        system = self._system
        if not system.constraints.moving:
            return 0.0
        driven = np.where(system.constraints.prescribed, now.velocity, 0.0)
        return 0.5 * system.product(driven, system.mass.apply(driven))


def _runaway(reason: str, energies: Energies, time: float, step: float) -> DivergenceError:
    return DivergenceError(
        f"at {time:.6g} s {reason}: kinetic {energies.kinetic:.4g} J, strain "
        f"{energies.strain:.4g} J, dissipated {energies.dissipated:.4g} J, work of loads and "
        f"prescribed motions {energies.external:.4g} J. Steps of {step:.6g} s are too long for "
        "this motion. The state before stands; try a smaller step, Newton's method iterated to a "
        "tolerance, more damping, or backward Euler",
        time=time,
        step=step,
        reason=reason,
    )
