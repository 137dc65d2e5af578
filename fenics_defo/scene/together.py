"""The processes of a run, as its loop sees them."""

from collections.abc import Callable
from typing import Protocol

from fenics_defo.errors import DefoError


class Together(Protocol):
    """The processes of a run; its methods are collective."""

    @property
    def is_first(self) -> bool:
        """Whether this is the process that writes."""

    def on_first[T](self, work: Callable[[], T]) -> T:
        """Do something on the first process and give its result, or its error, to all."""

    def any(self, here: bool) -> bool:
        """Whether it is so on any process: all must go the same way."""


class Alone:
    """One process."""

    is_first = True

    def on_first[T](self, work: Callable[[], T]) -> T:
        """Do it."""
        return work()

    def any(self, here: bool) -> bool:
        """Whether it is so."""
        return here


def with_our_errors[T](work: Callable[[], T]) -> T:
    """Do something, with the system's errors as ours, which the user can mend.

    Raises:
        DefoError: a file could not be read or written.
    """
    try:
        return work()
    except OSError as error:
        if isinstance(error, DefoError):
            raise
        named = "" if error.filename is None else f"{error.filename}: "
        raise DefoError(f"{named}{error.strerror or error}") from error
