"""Where a long computation is, on standard error; and the notes it makes."""

import contextlib
import importlib.util
import logging
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from fenics_defo.cli.output import can_style, write_text

_TICKER = Path(__file__).with_name("ticker.py")
_PAUSE = 0.1  # seconds between two messages about the same phase


class Progress:
    """The phase under way with its time, on a terminal; nothing elsewhere. Notes everywhere.

    Args:
        show: whether a display is wanted, where there is a terminal.
    """

    def __init__(self, *, show: bool) -> None:
        self._notes: list[str] = []
        self._silent = False
        self._is_terminal = sys.stderr.isatty()
        self._ticker = _start_ticker() if show and can_style(sys.stderr) else None
        self._moved = -_PAUSE

    def silence(self) -> None:
        """Show and write nothing from now on: another rank does."""
        self.stop()
        self._silent = True

    def start(self, phase: str) -> None:
        """Show that a phase has begun."""
        self._send(f"phase {phase}")

    def move(self, fraction: float, text: str) -> None:
        """Show how much of the phase is done, from 0 to 1; most calls of many do nothing."""
        now = time.monotonic()
        if self._ticker is not None and now - self._moved >= _PAUSE:
            self._moved = now
            self._send(f"at {fraction:.6f} {text}")

    def note(self, text: str) -> None:
        """Write one line ``note: ...``: now on a terminal, elsewhere when the work is done.

        A run that fails says one thing only, for scripts that pass it on.
        """
        line = " ".join(text.splitlines())
        if self._silent or self._send(f"note {line}"):
            return
        self._notes.append(f"note: {line}\n")
        if self._is_terminal:
            self.tell_notes()

    def tell_notes(self) -> None:
        """Write the notes that wait."""
        if self._notes:
            write_text(sys.stderr, "".join(self._notes))
        self._notes.clear()

    def stop(self) -> None:
        """Take the display away."""
        ticker, self._ticker = self._ticker, None
        if ticker is not None:
            with contextlib.suppress(OSError):
                ticker.communicate()

    def _send(self, line: str) -> bool:
        """Pass a line to the display, if there is one."""
        if self._ticker is None or self._ticker.stdin is None:
            return False
        try:
            self._ticker.stdin.write(line + "\n")
            self._ticker.stdin.flush()
        except OSError:  # it is gone: a display is no reason to stop the work
            self.stop()
            return False
        return True


def _start_ticker() -> "subprocess.Popen[str] | None":
    if importlib.util.find_spec("rich") is None:
        return None
    # -P keeps this folder, whose names are not meant for it, from its search path.
    command = [sys.executable, "-P", str(_TICKER)]
    try:
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, errors="replace"
        )
    except OSError:
        return None


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
