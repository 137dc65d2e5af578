"""Standard output and standard error: what is meant for them, as they can show it."""

import contextlib
import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from typing import TextIO

from fenics_defo.errors import DefoError


def write_text(stream: TextIO, text: str) -> None:
    """Write ``text`` now, escaping characters that the stream's encoding lacks.

    Raises:
        BrokenPipeError: nobody reads it any more.
        DefoError: it cannot be written for another reason, such as a full disk.
    """
    encoding = stream.encoding or "utf-8"
    try:
        stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise DefoError(f"{stream.name}: cannot be written ({error.strerror})") from error


def open_missing_streams() -> None:
    """Open what the shell closed (``>&-``), lest the next file opened takes its place."""
    for descriptor, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (kept to the end)
            if stream.fileno() != descriptor:
                os.dup2(stream.fileno(), descriptor)
            setattr(sys, name, stream)


@contextlib.contextmanager
def loading_libraries() -> Iterator[None]:
    """Guard an import of DOLFINx and its company.

    It shows them none of our arguments, for DOLFINx reads `sys.argv`, and takes the signal of
    broken pipes back from PETSc, which would abort where Python raises an error.
    """
    kept = sys.argv
    sys.argv = kept[:1]
    try:
        yield
    finally:
        sys.argv = kept
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGPIPE, signal.SIG_IGN)


def can_style(stream: TextIO) -> bool:
    """Whether escape codes make sense there: a terminal, and nobody asked for none."""
    plain = os.environ.get("NO_COLOR") or os.environ.get("TERM", "dumb") == "dumb"
    return stream.isatty() and not plain


def discard_stdout() -> None:
    """Let nothing more be written to a pipe that nobody reads, not even when Python ends."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


@contextlib.contextmanager
def libraries_on_stderr() -> Iterator[None]:
    """Send what libraries print to standard output to standard error instead.

    It covers Python and C: what scripts read from standard output must be ours alone.
    """
    c_library = ctypes.CDLL(None)
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        c_library.fflush(None)  # C's own buffers, before descriptor 1 is the user's again
        os.dup2(kept, 1)
        os.close(kept)
