"""Seconds spent in each phase of a long computation, and word of where it is."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass
class Phases:
    """A stopwatch with named phases; a phase entered again adds to its time.

    Args:
        on_start: called with the name of each phase as it begins.
        seconds: wall-clock time by phase [s], in the order of first entry.
    """

    on_start: Callable[[str], None] | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body of a ``with`` statement as the phase ``name``."""
        if self.on_start is not None:
            self.on_start(name)
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin
