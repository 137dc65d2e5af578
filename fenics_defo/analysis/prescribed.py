"""Displacements prescribed in time."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from fenics_defo.analysis.histories import History, Step
from fenics_defo.analysis.loads import checked_vector
from fenics_defo.errors import LoadError


@dataclass(frozen=True, slots=True)
class Prescribed:
    """Components of the displacement of selected nodes that follow u(t) = displacement · history.

    The nodes must not be held by the body in the same components; a region that is held at zero
    belongs to ``fixed`` of the body.

    Args:
        region: selection of nodes.
        displacement: [m] in x, y, z; None leaves a component free.
        history: factor over time; `Step` puts them there at once.

    Raises:
        LoadError: not three entries, not finite, or all three None.
    """

    region: str | int
    displacement: Sequence[float | None]
    history: History = field(default_factory=Step)

    def __post_init__(self) -> None:
        entries = tuple(self.displacement)
        if len(entries) != 3 or all(entry is None for entry in entries):
            raise LoadError(
                "displacement of Prescribed must have three entries, a number [m] or None (free), "
                f"and one number at least, got {self.displacement!r}"
            )
        numbers = [0.0 if entry is None else entry for entry in entries]
        x, y, z = checked_vector("Prescribed", numbers, "displacement")
        given = tuple(
            None if entry is None else number
            for entry, number in zip(entries, (x, y, z), strict=True)
        )
        object.__setattr__(self, "displacement", given)
        if not callable(self.history):
            raise LoadError(
                f"history of Prescribed must be Step, Ramp, Sine, Pulse, Table or a function of "
                f"time, got {self.history!r}"
            )
