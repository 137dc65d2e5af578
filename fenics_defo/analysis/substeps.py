"""A step that fails is halved and tried again."""

from collections.abc import Callable

from fenics_defo.analysis.instant import Instant, StepFailure
from fenics_defo.errors import DivergenceError

_ADVICE = (
    "try a smaller step, more damping, backward Euler, smaller loads, or one Newton iteration a "
    "step where it is iterated to a tolerance, and else the other way round"
)


def run_substeps(
    start: Instant,
    end: float,
    *,
    advance: Callable[[Instant, float], Instant],
    keep: Callable[[Instant, Instant], None],
    most: int,
) -> int:
    """Go from an instant to a time, in one step if possible.

    After a failure the step is halved, unless that cannot help; once the second half is done as
    well, the next is as long as both.

    Args:
        start: where to begin.
        end: [s].
        advance: does a step of a length [s] from an instant.
        keep: takes the start and the end of each step that was done.
        most: how often the whole may be halved.

    Returns:
        how often a step was halved.

    Raises:
        DivergenceError: a step failed that may not, or need not, be halved any more.
    """
    begin, whole = start.time, 2**most
    done, length, halvings = 0, whole, 0
    while done < whole:
        time = end if done + length == whole else begin + (end - begin) * (done + length) / whole
        try:
            reached = advance(start, time - start.time)
        except StepFailure as failure:
            if length == 1 or failure.lasting:
                raise _divergence(start.time, end - begin, length / whole, failure) from failure
            length //= 2
            halvings += 1
            continue
        keep(start, reached)
        start, done = reached, done + length
        while done % (2 * length) == 0 and 2 * length <= whole and done < whole:
            length *= 2
    return halvings


def _divergence(time: float, step: float, part: float, failure: StepFailure) -> DivergenceError:
    history = ", ".join(f"{residual:.1e}" for residual in failure.residuals[-8:])
    more = "..., " if len(failure.residuals) > 8 else ""
    said = f"; relative residuals {more}{history}" if history else ""
    halved = f", nor one of {step * part:.3g} s" if part < 1.0 else ""
    message = (
        f"no step of {step:.6g} s was found at {time:.6g} s{halved}: {failure.reason}{said}. "
        "The state at that time stands"
    )
    return DivergenceError(
        message if failure.lasting else f"{message}; {_ADVICE}",
        time=time,
        step=step * part,
        residuals=failure.residuals,
        reason=failure.reason,
    )
