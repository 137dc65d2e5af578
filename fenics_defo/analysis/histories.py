"""How loads and prescribed motions vary in time: factors of time, each a small checked record.

Anything that is called with a time [s] and returns a number may stand in their place.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from fenics_defo.errors import LoadError

type History = Callable[[float], float]


@dataclass(frozen=True, slots=True)
class Step:
    """One from ``start`` on, zero before.

    Args:
        start: [s].

    Raises:
        LoadError: ``start`` is not finite.
    """

    start: float = 0.0

    def __post_init__(self) -> None:
        _finite("Step", "start", self.start)

    def __call__(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return 1.0 if time >= self.start else 0.0


@dataclass(frozen=True, slots=True)
class Ramp:
    """Zero until ``start``, then linear to one within ``duration``, then one.

    Args:
        duration: [s], positive.
        start: [s].

    Raises:
        LoadError: a number is not finite, or ``duration`` not positive.
    """

    duration: float
    start: float = 0.0

    def __post_init__(self) -> None:
        _positive("Ramp", "duration", self.duration)
        _finite("Ramp", "start", self.start)

    def __call__(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return min(max((time - self.start) / self.duration, 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class Sine:
    """sin(2 π f t + φ).

    Args:
        frequency: f [Hz], positive.
        phase: φ [rad].

    Raises:
        LoadError: a number is not finite, or ``frequency`` not positive.
    """

    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        _positive("Sine", "frequency", self.frequency)
        _finite("Sine", "phase", self.phase)

    def __call__(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return math.sin(2.0 * math.pi * self.frequency * time + self.phase)


@dataclass(frozen=True, slots=True)
class Pulse:
    """One for start <= t < start + duration, zero before and after.

    Args:
        start: [s].
        duration: [s], positive.

    Raises:
        LoadError: a number is not finite, or ``duration`` not positive.
    """

    start: float
    duration: float

    def __post_init__(self) -> None:
        _finite("Pulse", "start", self.start)
        _positive("Pulse", "duration", self.duration)

    def __call__(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return 1.0 if self.start <= time < self.start + self.duration else 0.0


@dataclass(frozen=True, slots=True)
class Table:
    """Linear between the rows of a table, constant before the first and after the last.

    Args:
        times: (k,) [s], ascending.
        values: (k,) factors.

    Raises:
        LoadError: the columns are empty, of different length or not finite, or the times do not
            ascend.
    """

    times: Sequence[float]
    values: Sequence[float]

    def __post_init__(self) -> None:
        times, values = (tuple(map(float, column)) for column in (self.times, self.values))
        if not times or len(times) != len(values):
            raise LoadError(
                f"a Table needs as many times as values and at least one, got {len(times)} times "
                f"and {len(values)} values"
            )
        for name, column in (("times", times), ("values", values)):
            for number in column:
                _finite("Table", name, number)
        for before, after in pairwise(times):
            if not before < after:
                raise LoadError(
                    f"the times of a Table must ascend, got {after:g} s after {before:g} s"
                )
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        after = bisect_right(self.times, time)
        if after == 0:
            return self.values[0]
        if after == len(self.times):
            return self.values[-1]
        t0, t1 = self.times[after - 1 : after + 1]
        f0, f1 = self.values[after - 1 : after + 1]
        return f0 + (f1 - f0) * ((time - t0) / (t1 - t0))


def _finite(record: str, name: str, value: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise LoadError(f"{name} of {record} must be a finite number, got {value!r}")


def _positive(record: str, name: str, value: float) -> None:
    _finite(record, name, value)
    if not value > 0.0:
        raise LoadError(f"{name} of {record} must be positive, got {value!r}")
