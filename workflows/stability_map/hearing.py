"""What the program says while it computes: warnings that it logs."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager


class _Ear(logging.Handler):
    """Keeps each different warning once."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Keep it, if it is new."""
        self.said[record.getMessage()] = None


@contextmanager
def listen() -> Iterator[dict[str, None]]:
    """Warnings of the package logged meanwhile, in their order."""
    ear, logger = _Ear(), logging.getLogger("fenics_defo")
    passes_on = logger.propagate
    logger.addHandler(ear)
    logger.propagate = False
    try:
        yield ear.said
    finally:
        logger.removeHandler(ear)
        logger.propagate = passes_on
