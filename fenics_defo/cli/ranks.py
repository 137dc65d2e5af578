"""The MPI ranks of a command: what one does for all, and how they end together."""

import time
from collections.abc import Callable
from typing import NoReturn

from fenics_defo.errors import DefoError
from fenics_defo.fem.compat import MPI
from fenics_defo.fem.ranks import on_first_rank

_PATIENCE = 10.0  # seconds that ranks with the same error may lie apart
_POLL = 0.01


class Ranks:
    """All ranks of this run, with a communicator of their own. Making it is collective."""

    def __init__(self) -> None:
        # A copy: ranks that wait here after an error must not be mistaken for ranks that take
        # part in the computation's next collective call.
        self._comm = MPI.COMM_WORLD.Dup()

    @property
    def is_first(self) -> bool:
        """Whether this is the rank that prints and writes."""
        return bool(self._comm.rank == 0)

    @property
    def are_many(self) -> bool:
        """Whether other ranks could wait for this one."""
        return bool(self._comm.size > 1)

    def on_first[T](self, work: Callable[[], T]) -> T:
        """Do something on rank 0 and give its result, or the user's error, to all ranks."""

        def work_with_our_errors() -> T:
            try:
                return work()
            except OSError as error:
                if isinstance(error, DefoError):
                    raise
                named = "" if error.filename is None else f"{error.filename}: "
                raise DefoError(f"{named}{error.strerror or error}") from error

        return on_first_rank(self._comm, work_with_our_errors)

    def all_here(self) -> bool:
        """Whether all ranks arrive here within some seconds; asked after an error."""
        request = self._comm.Ibarrier()
        deadline = time.monotonic() + _PATIENCE
        while not request.Test():
            if time.monotonic() > deadline:
                return False
            time.sleep(_POLL)
        return True

    def abort(self, status: int) -> NoReturn:
        """End all ranks at once."""
        MPI.COMM_WORLD.Abort(status)
        raise AssertionError("unreachable")
