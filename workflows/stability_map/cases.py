"""A cell that is to be computed, and what came of it."""

from collections.abc import Callable
from dataclasses import dataclass

from workflows.stability_map.outcomes import Measured, Outcome

#: Seconds after which a cell counts as hanging, on a machine that may be busy with other work.
PATIENCE = 120.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One cell.

    Args:
        sweep: title of the table it belongs to.
        row: what is computed, and with what.
        column: value of what is swept.
        compute: called without arguments in another process, so it must be picklable.
        patience: seconds after which it is given up.
    """

    sweep: str
    row: str
    column: str
    compute: Callable[[], Measured]
    patience: float = PATIENCE


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell, computed.

    Args:
        sweep: title of its table.
        row: its row.
        column: its column.
        outcome: what came of it.
        seconds: how long it took.
    """

    sweep: str
    row: str
    column: str
    outcome: Outcome
    seconds: float
