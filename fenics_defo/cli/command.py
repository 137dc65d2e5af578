"""How each command begins and ends: its parser, its errors in one sentence, its exit status."""

import argparse
import contextlib
import os
import signal
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
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
    "view": {"PIL", "pyvista", "vtkmodules"},
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
    """

    command: str
    ranks: "Ranks | None" = None

    @property
    def is_first(self) -> bool:
        """Whether this process is the one that prints."""
        return is_first_process() if self.ranks is None else self.ranks.is_first

    def fail(self, sentence: str) -> int:
        """Say on rank 0 why the run ends, and return the exit status once all ranks agree."""
        line = f"{self.command}: {sentence}\n"
        together = self.ranks is None or self.ranks.all_here()
        if self.is_first or not together:
            _tell(line)
        if self.ranks is not None and not together:
            self.ranks.abort(FAILED)
        return FAILED


def run(command: str, work: Callable[[Run], None]) -> int:
    """Do the work of a command and return its exit status.

    0 done; 1 the user's error, one sentence on standard error; 130 interrupted. Another exception
    is a fault of ours: it goes on as it is, and under MPI ends all ranks after its traceback.

    Args:
        command: name of the command.
        work: what it does, with the run to register its ranks with.
    """
    open_missing_streams()
    current = Run(command)
    try:
        work(current)
        sys.stdout.flush()
    except KeyboardInterrupt:
        _tell(f"{command}: interrupted; no file is left half-written\n")
        if current.ranks is not None and current.ranks.are_many:
            current.ranks.abort(INTERRUPTED)
        return INTERRUPTED
    except BrokenPipeError:
        discard_stdout()
        return READER_GONE
    except (DefoError, OSError, MemoryError) as error:
        return current.fail(_sentence(error))
    except ImportError as error:
        extra = next((e for e, names in _EXTRAS.items() if _library(error) in names), None)
        if extra is None:
            raise
        return current.fail(
            f"the library {_library(error)} is not installed: pip install 'fenics_defo[{extra}]'"
        )
    except BaseException:
        if current.ranks is None or not current.ranks.are_many:
            raise
        traceback.print_exc()
        current.ranks.abort(FAILED)
    return 0


def _tell(line: str) -> None:
    """Write to standard error, if anybody listens."""
    with contextlib.suppress(OSError, DefoError):
        write_text(sys.stderr, line)


def _sentence(error: BaseException) -> str:
    """What a user's error says, on one line."""
    if isinstance(error, MemoryError):
        return "the memory does not suffice; use a coarser mesh, --order 1 or --solver iterative"
    if isinstance(error, OSError) and not isinstance(error, DefoError) and error.strerror:
        named = "" if error.filename is None else f"{os.fsdecode(error.filename)}: "
        return f"{named}{error.strerror}"
    return " ".join(str(error).splitlines())


def _library(error: ImportError) -> str:
    return (error.name or "").partition(".")[0]
