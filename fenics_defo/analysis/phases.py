"""Seconds spent in each phase of a long computation, and word of where it is."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass
class Phases:
    """A stopwatch with named phases; a phase entered again adds to its time.

    A phase within another stops the clock of the outer one: the times add up to no more than what
    went by.

    Args:
        on_start: called with the name of each phase as it begins.
        seconds: wall-clock time by phase [s], in the order of first entry.
    """

    on_start: Callable[[str], None] | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    _inner: float = field(default=0.0, init=False, repr=False, compare=False)

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body of a ``with`` statement as the phase ``name``."""
        if self.on_start is not None:
            self.on_start(name)
        self.seconds.setdefault(name, 0.0)
        outer, self._inner = self._inner, 0.0
        begin = time.perf_counter()
        try:
            yield
        finally:
            passed = time.perf_counter() - begin
            self.seconds[name] += passed - self._inner
            self._inner = outer + passed

    def add(self, name: str, passed: float) -> None:
        """Count time that went by within the phase under way as another one's.

        For what is short and comes often: nobody is told that it begins.

        Args:
            name: of the other phase.
            passed: time by the clock [s].
        """
        self.seconds[name] = self.seconds.get(name, 0.0) + passed
        self._inner += passed
