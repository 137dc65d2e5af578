"""Who looks on while a scene is simulated, and may stop it."""

from collections.abc import Callable
from dataclasses import dataclass, field

from fenics_defo.analysis import Phases


@dataclass(frozen=True, slots=True, kw_only=True)
class Watcher:
    """Who looks on while a scene is simulated.

    Args:
        phases: stopwatch for "read", "build", "start", "simulate" and "write".
        moved: called with the steps done, the steps in all and the time reached [s].
        stop: asked after each step, on each rank, whether to stop there.
    """

    phases: Phases = field(default_factory=Phases)
    moved: Callable[[int, int, float], None] = lambda _done, _all, _time: None
    stop: Callable[[], bool] = lambda: False
