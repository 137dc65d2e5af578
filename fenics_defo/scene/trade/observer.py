"""Who looks on while candidates are measured."""

from collections.abc import Callable
from dataclasses import dataclass, field

from fenics_defo.analysis import Phases


def _nothing(_part: float, _text: str) -> None:
    pass


@dataclass(frozen=True, slots=True, kw_only=True)
class Observer:
    """Who looks on while candidates are measured.

    Args:
        phases: stopwatch of "read", "build", "reference", "candidates" and "write".
        moved: called with the part that is done, 0 to 1, and what is under way.
    """

    phases: Phases = field(default_factory=Phases)
    moved: Callable[[float, str], None] = _nothing
