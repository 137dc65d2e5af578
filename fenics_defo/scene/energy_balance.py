"""Whether a model in motion has more energy than was ever put into it; NumPy only."""

import math

from fenics_defo.analysis.states import Energies
from fenics_defo.errors import DivergenceError

# Gain at which a motion has run away: half of its energy comes from nothing.
_RUNAWAY = 1.0
_EVERY = 32
# Nearest to its limit that a step of an explicit method is taken to be.
_NEAREST = 0.98


class EnergyBalance:
    """The energy balance of a model, as `Simulation` watches that of a body, but more simply.

    gain = (T + U - T0 - U0 + max D - W) / (T0 + |U0| + max |W|), zeroes for the start, maxima over
    the time since then. Explicit methods keep another energy than T + U, which may therefore grow
    by 2 r / (1 - r) without error at r times their largest stable step: that is allowed them.

    Args:
        start: energies at the start.
        step: [s].
        limit: largest stable step of an explicit method [s]; infinite for others.
        lenient: whether a runaway is let go on.
    """

    def __init__(
        self, start: Energies, *, step: float, limit: float = math.inf, lenient: bool = False
    ) -> None:
        self._begin = start.kinetic + start.strain
        self._scale = start.kinetic + abs(start.strain)
        self._step, self._lenient = step, lenient
        near = min(step / limit, _NEAREST)
        self._allowed = _RUNAWAY + 2.0 * near / (1.0 - near)
        self._most_work = self._most_dissipated = 0.0
        #: Largest |T + U + D - W - its value at the start| over the scale so far [-].
        self.error = 0.0
        #: Largest gain so far [-].
        self.gain = 0.0

    def is_due(self, steps: int) -> bool:
        """Whether to judge after so many steps."""
        return steps % _EVERY == 0

    def look(self, energies: Energies) -> None:
        """Take note of the energies at a time."""
        self._most_work = max(self._most_work, abs(energies.external))
        self._most_dissipated = max(self._most_dissipated, energies.dissipated)
        scale = self._scale + self._most_work
        if not scale > 0.0:
            return
        change = energies.kinetic + energies.strain - self._begin - energies.external
        self.gain = max(self.gain, (change + self._most_dissipated) / scale)
        self.error = max(self.error, abs(change + energies.dissipated) / scale, self.gain)

    def judge(self, energies: Energies, time: float) -> None:
        """`look`, and refuse a motion that has run away.

        Args:
            energies: at the time.
            time: [s].

        Raises:
            DivergenceError: it has, or its energy is no number.
        """
        self.look(energies)
        finite = math.isfinite(energies.balance)
        if finite and (self._lenient or self.gain <= self._allowed):
            return
        reason = (
            f"the model has gained {self.gain:.3g} times all the energy ever put into it"
            if finite
            else "the energy is infinite or no number"
        )
        raise DivergenceError(
            f"at {time:.6g} s {reason}: steps of {self._step:.6g} s are too long for this motion; "
            "try a smaller step, Newton's method iterated to a tolerance, more damping, or "
            "backward Euler",
            time=time,
            step=self._step,
            reason=reason,
        )
