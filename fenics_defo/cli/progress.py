"""Where a long computation is, on standard error; and the notes it makes."""

import contextlib
import logging
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from fenics_defo.cli.output import can_style, write_text

if TYPE_CHECKING:
    from rich.progress import Progress as RichProgress


class Progress:
    """The phase under way with its time, on a terminal; nothing elsewhere. Notes everywhere.

    Args:
        show: whether a display is wanted, where there is a terminal.
    """

    def __init__(self, *, show: bool) -> None:
        self._silent = False
        self._notes: list[str] = []
        self._is_terminal = sys.stderr.isatty()
        self._display = _display() if show and can_style(sys.stderr) else None
        if self._display is not None:
            self._task = self._display.add_task("", total=None)

    def silence(self) -> None:
        """Show and write nothing from now on: another rank does."""
        self.stop()
        self._display = None
        self._silent = True

    def start(self, phase: str) -> None:
        """Show that a phase has begun."""
        if self._display is not None:
            self._display.reset(self._task, description=phase)
            self._display.start()
            self._display.refresh()  # the thread that redraws may not run while PETSc computes

    def stop(self) -> None:
        """Take the display away."""
        if self._display is not None:
            self._display.stop()

    def note(self, text: str) -> None:
        """Write one line ``note: ...``: now on a terminal, elsewhere when the work is done.

        A run that fails says one thing only, for scripts that pass it on.
        """
        self._notes.append(f"note: {' '.join(text.splitlines())}\n")
        if self._is_terminal:
            self.stop()
            self.tell_notes()

    def tell_notes(self) -> None:
        """Write the notes that wait."""
        if not self._silent:
            write_text(sys.stderr, "".join(self._notes))
        self._notes.clear()


class _Notes(logging.Handler):
    """Warnings of the package as notes."""

    def __init__(self, progress: Progress) -> None:
        super().__init__(logging.WARNING)
        self._progress = progress

    def emit(self, record: logging.LogRecord) -> None:
        self._progress.note(record.getMessage())


@contextlib.contextmanager
def progress_shown(*, show: bool) -> Iterator[Progress]:
    """Show progress, and the package's warnings as notes, while the block runs.

    Args:
        show: whether to show the phases on a terminal.
    """
    progress = Progress(show=show)
    logger = logging.getLogger("fenics_defo")
    handler = _Notes(progress)
    before = logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield progress
        progress.stop()
        progress.tell_notes()
    finally:
        progress.stop()
        logger.removeHandler(handler)
        logger.propagate = before


def _display() -> "RichProgress | None":
    try:
        from rich.console import Console
        from rich.progress import Progress as RichProgress
        from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn
    except ImportError:  # a display is no reason to refuse the work
        return None
    return RichProgress(
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
