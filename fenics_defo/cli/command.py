"""How each command begins and ends: its parser, its errors in one sentence, its exit status."""

import argparse
import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

from fenics_defo.cli.output import discard_stdout, open_missing_streams, write_text
from fenics_defo.errors import DefoError

if TYPE_CHECKING:
    from fenics_defo.cli.ranks import Ranks

FAILED = 1
INTERRUPTED = 128 + signal.SIGINT
READER_GONE = 128 + signal.SIGPIPE  # what a shell reports of a program that SIGPIPE ended

# Where MPI's launchers tell a process its rank: MPICH and Intel, Open MPI, PMIx, Slurm. They are
# asked before MPI is loaded, so that only one rank prints the help or a misspelt option.
_RANK_VARIABLES = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "PMIX_RANK", "SLURM_PROCID")

# What the parts of the package need, by the name it is imported by.
_EXTRAS = {
    "fem": {"basix", "dolfinx", "ffcx", "gmsh", "h5py", "meshio", "rich", "scipy", "ufl"},
    "view": {"PIL", "matplotlib", "pyvista", "vtkmodules"},
}


def is_first_process() -> bool:
    """Whether this process is rank 0 or alone, by what its launcher says."""
    return next((os.environ[v] for v in _RANK_VARIABLES if v in os.environ), "0") == "0"


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one sentence and the exit status 1, from one rank."""

    def __init__(self, **options: object) -> None:
        super().__init__(
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            **options,  # type: ignore[arg-type]
        )

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the command line and leave."""
        self.exit(FAILED, f"{self.prog}: {message}; see {self.prog} --help\n")

    def _print_message(self, message: str, file: Any = None) -> None:
        if is_first_process():
            super()._print_message(message, file)


def positive_count(text: str) -> int:
    """Read a whole number from 1, for `argparse`."""
    if not text.strip().isdecimal() or not int(text) >= 1:
        raise argparse.ArgumentTypeError(f"must be a whole number from 1, got {text!r}")
    return int(text)


def number(text: str) -> float:
    """Read a number, for `argparse`; its range is checked where it is used."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, got {text!r}") from None


@dataclass
class Run:
    """One run of a command.

    Args:
        command: its name, to begin sentences with.
        ranks: the MPI ranks, once MPI is loaded.
        interrupted: whether Ctrl-C was pressed, to end the run at once.
        asked_to_stop: whether Ctrl-C was pressed where it waits for the step under way.
        stopped: what to say of a run that all ranks have then ended in good order.
        status: exit status of a run that has done its work.
    """

    command: str
    ranks: "Ranks | None" = None
    interrupted: bool = False
    asked_to_stop: bool = False
    stopped: str = ""
    status: int = 0

    @property
    def is_first(self) -> bool:
        """Whether this process is the one that prints."""
        return is_first_process() if self.ranks is None else self.ranks.is_first

    def go_on(self) -> None:
        """Stop here if Ctrl-C was pressed and a library has swallowed the exception.

        Raises:
            KeyboardInterrupt: it was.
        """
        if self.interrupted:
            raise KeyboardInterrupt

    @contextlib.contextmanager
    def interrupts_wait(self) -> Iterator[Callable[[], bool]]:
        """Let Ctrl-C ask for a good place to stop; pressed again, it ends the run at once.

        Yields:
            whether it was pressed.
        """

        def interrupt(_number: int, _frame: FrameType | None) -> None:
            if self.asked_to_stop:
                self.interrupted = True
                raise KeyboardInterrupt
            self.asked_to_stop = True

        before = signal.getsignal(signal.SIGINT)
        in_main_thread = threading.current_thread() is threading.main_thread()
        if not callable(before) or not in_main_thread:
            yield lambda: self.asked_to_stop  # ignored, as under nohup, or another's business
            return
        signal.signal(signal.SIGINT, interrupt)
        try:
            yield lambda: self.asked_to_stop
        finally:
            signal.signal(signal.SIGINT, before)

    def stop(self, sentence: str) -> NoReturn:
        """End a run that Ctrl-C has asked to stop, on all ranks, with what there is to say."""
        self.stopped = sentence
        raise KeyboardInterrupt

    def fail(self, sentence: str) -> int:
        """Say on rank 0 why the run ends, and return the exit status once all ranks agree."""
        line = f"{self.command}: {sentence}\n"
        together = self.ranks is None or self.ranks.all_here()
        if self.is_first or not together:
            _tell(line)
        if self.ranks is not None and not together:
            self.ranks.abort(FAILED)
        return FAILED

    def end_interrupted(self) -> int:
        """Say that Ctrl-C ends the run, end all ranks, and return the exit status."""
        if self.stopped:
            if self.is_first:
                _tell(f"{self.command}: {self.stopped}\n")
            return INTERRUPTED
        _tell(f"{self.command}: interrupted; no file is left half-written\n")
        if self.ranks is not None and self.ranks.are_many:
            self.ranks.abort(INTERRUPTED)
        return INTERRUPTED


def run(command: str, work: Callable[[Run], None]) -> int:
    """Do the work of a command and return its exit status.

    That of the run, mostly 0, if it is done; 1 the user's error, one sentence on standard error;
    130 interrupted. Another exception is a fault of ours: it goes on as it is, and under MPI
    ends all ranks after its traceback.

    Args:
        command: name of the command.
        work: what it does, with the run to register its ranks with.
    """
    # MUMPS's products are small: threads of the BLAS wait for each other more than they help.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    open_missing_streams()
    current = Run(command)
    try:
        with _interrupts_noted(current):
            work(current)
        sys.stdout.flush()
    except BaseException as error:
        # A compiler of kernels that Ctrl-C ends too fails with an error of its own.
        swallowed = current.asked_to_stop and _sentence(error) is None
        if current.interrupted or swallowed or isinstance(error, KeyboardInterrupt):
            return current.end_interrupted()
        if isinstance(error, BrokenPipeError):
            discard_stdout()
            return READER_GONE
        sentence = _sentence(error)
        if sentence is not None:
            return current.fail(sentence)
        if current.ranks is None or not current.ranks.are_many:
            raise
        traceback.print_exc()
        current.ranks.abort(FAILED)
    return current.status


@contextlib.contextmanager
def _interrupts_noted(current: Run) -> Iterator[None]:
    """Raise KeyboardInterrupt on Ctrl-C, and remember it: compilers of kernels may swallow it."""

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        current.interrupted = True
        raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    in_main_thread = threading.current_thread() is threading.main_thread()
    if before is not signal.default_int_handler or not in_main_thread:
        yield  # ignored, as under nohup, or another's business
        return
    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _tell(line: str) -> None:
    """Write to standard error, if anybody listens."""
    with contextlib.suppress(OSError, DefoError):
        write_text(sys.stderr, line)


def _sentence(error: BaseException) -> str | None:
    """What a user's error says, on one line; None for a fault of ours."""
    if isinstance(error, DefoError):
        return " ".join(str(error).splitlines())
    if isinstance(error, MemoryError):
        return "the memory does not suffice; use a coarser mesh, --order 1 or --solver iterative"
    if isinstance(error, OSError):
        named = "" if error.filename is None else f"{os.fsdecode(error.filename)}: "
        return " ".join(f"{named}{error.strerror or error}".splitlines())
    if isinstance(error, ImportError):
        library = _library(error)
        for extra, names in _EXTRAS.items():
            if library in names:
                return f"{library} is not installed: pip install 'fenics_defo[{extra}]'"
    return None


def _library(error: ImportError) -> str:
    return (error.name or "").partition(".")[0]
