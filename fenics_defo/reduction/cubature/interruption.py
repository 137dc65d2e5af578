"""Ctrl-C as a request to stop, which all ranks hear at the same point of their work."""

import signal
import threading
from types import FrameType
from typing import Any, Self

from fenics_defo.fem.compat import MPI


class Interruption:
    """Within a with statement, notes Ctrl-C instead of raising; the second one raises.

    Args:
        comm: communicator.
    """

    def __init__(self, comm: MPI.Comm) -> None:
        self._comm = comm
        self._noted = False
        self._before: Any = None
        #: Whether all ranks have been told to stop.
        self.heard = False

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGINT, self._interrupted)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def note(self) -> None:
        """Ask for an end."""
        self._noted = True

    def asked(self) -> bool:
        """Whether an end was asked for on any rank; collective."""
        self.heard = self.heard or bool(self._comm.allreduce(self._noted, op=MPI.LOR))
        return self.heard

    def _interrupted(self, number: int, frame: FrameType | None) -> None:
        if self._noted:
            raise KeyboardInterrupt
        self._noted = True
