"""What a cell of the map may be, and how a computation's result is judged."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from fenics_defo.errors import DefoError, DivergenceError, EigenSolveError, SolverError

# Error up to which a result counts as right.
RIGHT = 1e-2
# Error allowed where the discrete solution itself is known in closed form.
EXACT = 1e-6
# Growth of the energy or amplitude of a motion without loads beyond which it is unstable.
GROWTH = 4.0


class Kind(StrEnum):
    """The first four are sound; the others must not be."""

    RIGHT = "right"
    INACCURATE = "stable, inaccurate"
    REFUSED = "refused"
    DIVERGED = "diverged"
    HANG = "HANG"
    CRASH = "CRASH"
    SILENT_NAN = "SILENT NaN"
    WRONG = "WRONG, called right"

    @property
    def sound(self) -> bool:
        """Whether a user can live with it."""
        return self in (Kind.RIGHT, Kind.INACCURATE, Kind.REFUSED, Kind.DIVERGED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What a computation that ended without an error gave.

    Args:
        error: against the independent reference, relative [-].
        theory: distance from what the method must give by its own theory [-], if that is known.
        growth: largest energy or amplitude over the first, of a motion without loads [-].
        wrong: why the result may not be called one, whatever its error.
        note: what else there is to say.
    """

    error: float
    theory: float = 0.0
    growth: float = 1.0
    wrong: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True)
class Outcome:
    """A cell of the map.

    Args:
        kind: what happened.
        error: relative error, where there is a result.
        message: what the program said, or what is wrong.
    """

    kind: Kind
    error: float | None = None
    message: str = ""


def outcome_of(compute: Callable[[], Measured]) -> Outcome:
    """Compute and judge: a `DefoError` is a message, any other exception a crash."""
    try:
        return judged(compute())
    except DivergenceError as error:
        return Outcome(Kind.DIVERGED, message=str(error))
    except EigenSolveError as error:
        return Outcome(Kind.REFUSED, message=str(error))
    except SolverError as error:
        return Outcome(Kind.DIVERGED, message=str(error))
    except DefoError as error:
        return Outcome(Kind.REFUSED, message=str(error))
    except Exception as error:
        return Outcome(Kind.CRASH, message=f"{type(error).__name__}: {error}")


def judged(result: Measured) -> Outcome:
    """A result without an error message, as a cell."""
    numbers = (result.error, result.theory, result.growth)
    if not all(math.isfinite(number) for number in numbers):
        said = f"error {result.error:g}, growth {result.growth:g}: a number is not finite"
        said += f"; {result.note}" if result.note else ""
        return Outcome(Kind.SILENT_NAN, message=said)
    if result.wrong:
        return Outcome(Kind.WRONG, result.error, result.wrong)
    if not result.theory <= EXACT:
        return Outcome(
            Kind.WRONG, result.error, f"{result.theory:.1e} from the exact discrete solution"
        )
    if not result.growth <= GROWTH:
        return Outcome(Kind.WRONG, result.error, f"grew {result.growth:.1e} times without a word")
    kind = Kind.RIGHT if result.error <= RIGHT else Kind.INACCURATE
    return Outcome(kind, result.error, result.note)
