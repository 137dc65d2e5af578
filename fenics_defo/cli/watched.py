"""A run of a scene on the command line: its display, Ctrl-C, and what a step that fails says."""

import contextlib
import time
from collections.abc import Iterator

from fenics_defo.analysis.phases import Phases
from fenics_defo.cli.command import Run
from fenics_defo.cli.progress import Progress
from fenics_defo.errors import DefoError, DivergenceError
from fenics_defo.scene.watching import Watcher


def shown_phases(current: Run, progress: Progress, begin: float) -> Phases:
    """A stopwatch whose phases are shown, begun with what loading the libraries took.

    Args:
        current: this run.
        progress: display.
        begin: `time.perf_counter` when the command began [s].
    """

    def enter(phase: str) -> None:
        current.go_on()
        progress.start(phase)

    return Phases(on_start=enter, seconds={"load": time.perf_counter() - begin})


@contextlib.contextmanager
def watched(
    duration: float, output: str, *, current: Run, progress: Progress, begin: float, verb: str
) -> Iterator[Watcher]:
    """Look on while a scene runs into a folder.

    Args:
        duration: of the scene [s].
        output: the folder.
        current: this run.
        progress: display.
        begin: `time.perf_counter` when the command began [s].
        verb: what the display says is done.

    Yields:
        who looks on.

    Raises:
        DefoError: a step failed; it says where the results are.
    """

    def moved(done: int, total: int, now: float) -> None:
        progress.move(done / total, f"{verb} {now:.4g} s of {duration:.4g} s")

    phases = shown_phases(current, progress, begin)
    with current.interrupts_wait() as asked:
        try:
            yield Watcher(phases=phases, moved=moved, stop=asked)
        except DivergenceError as error:
            told = str(error).rstrip(".")
            raise DefoError(f"{told}. {output} holds all until then.") from error
