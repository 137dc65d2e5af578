"""The largest stable step of explicit methods, looked at again as the body stiffens."""

import math
from typing import TYPE_CHECKING

from fenics_defo.analysis.frequency_bound import largest_frequency
from fenics_defo.analysis.instant import Forces, Instant
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.errors import StepSizeError

if TYPE_CHECKING:
    from fenics_defo.analysis.system import System

# Steps after which the limit is looked at again: a stretched body is stiffer.
_LIMIT_EVERY = 256
# Steps after which it is looked at whether the motion grows by itself: cheap.
_GROWTH_EVERY = 4


class StepLimit:
    """How long a step may be; collective.

    Args:
        system: the equations.
        integrator: method; only explicit ones have a limit.
        step: the step that is wanted [s].
        allow_unstable: never refuse it.
    """

    def __init__(
        self, system: "System", integrator: Integrator, step: float, *, allow_unstable: bool
    ) -> None:
        self._system, self._integrator, self._step = system, integrator, step
        #: Whether no step is refused.
        self.allow_unstable = allow_unstable
        self._value: float | None = None

    def at(self, instant: Instant) -> float:
        """The limit [s] when last looked at, which may be at this instant; infinite if none."""
        if self._value is None:
            self._value = math.inf
            if self._integrator.explicit:
                system = self._system
                local = system.local(instant.displacement)
                omega = largest_frequency(system.solid, local, system.free)
                self._value = self._integrator.critical_step(omega, system.settings.damping)
        return self._value

    def check(self, instant: Instant) -> None:
        """Refuse a step beyond the limit, looked at again at ``instant``.

        Raises:
            StepSizeError: the step is beyond it.
        """
        self._value = None
        limit = self.at(instant)
        if self.allow_unstable or self._step <= limit:
            return
        raise StepSizeError(
            f"the step of {self._step:.6g} s is beyond {limit:.6g} s, the largest stable step of "
            f"{type(self._integrator).__name__} at {instant.time:.6g} s; take 0.9 of that, an "
            "implicit method, fewer slivers in the mesh, or set allow_unstable to true"
        )

    def check_now_and_then(self, instant: Instant, steps: int) -> None:
        """`check` where the number of steps done says so.

        Raises:
            StepSizeError: the step is beyond the limit.
        """
        if self._is_kept and steps and steps % _LIMIT_EVERY == 0:
            self.check(instant)

    def check_growth(
        self, start: Instant, reached: Instant, before: Forces, after: Forces, steps: int
    ) -> None:
        """`check` once the motion of a step is itself beyond the limit.

        A mode that grows soon rules the motion, and then Δu·Δf / Δu·MΔu is its ω².

        Raises:
            StepSizeError: the step is beyond the limit.
        """
        if not self._is_kept or steps % _GROWTH_EVERY:
            return
        system = self._system
        change = reached.displacement - start.displacement
        stiff = system.product(change, after.internal - before.internal)
        heavy = system.product(change, system.mass.apply(change))
        squared = stiff / heavy if heavy > 0.0 else 0.0
        damping = system.settings.damping
        if squared > 0.0 and (
            self._integrator.critical_step(math.sqrt(squared), damping) < self._step
        ):
            self.check(start)

    @property
    def _is_kept(self) -> bool:
        return self._integrator.explicit and not self.allow_unstable
