"""Reads the numbers of a .msh section one after another, from text or from bytes alike."""

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError

Integers = NDArray[np.int64]


class MshCursor:
    """A position in the numbers of one section.

    Args:
        body: bytes between ``$Section`` and ``$EndSection``.
        binary: whether they are raw numbers or text.
        swap: whether the bytes come from a machine of the other byte order.
        what: path and section, to begin a sentence with.
    """

    def __init__(self, body: bytes, *, binary: bool, swap: bool, what: str) -> None:
        self.binary, self.swap, self.what = binary, swap, what
        self.position = 0
        self.body = body
        self.values = np.empty(0) if binary else text_numbers(body, what)

    def integers(self, count: int) -> Integers:
        """The next ``count`` 32-bit integers."""
        return self._take(count, "i4").astype(np.int64)

    def sizes(self, count: int) -> Integers:
        """The next ``count`` 64-bit integers (``size_t`` of format 4.1)."""
        return self._take(count, "i8").astype(np.int64)

    def doubles(self, count: int) -> NDArray[np.float64]:
        """The next ``count`` double-precision numbers."""
        return self._take(count, "f8").astype(np.float64)

    def records(
        self, dtype: list[tuple[str, str, tuple[int, ...]]], count: int
    ) -> NDArray[np.void]:
        """The next ``count`` packed records; binary files only."""
        kind = np.dtype(dtype)
        return self._bytes(count, kind.newbyteorder() if self.swap else kind)

    def rows_left(self, width: int) -> int:
        """How many rows of ``width`` numbers still fit; text files only."""
        return (len(self.values) - self.position) // width

    def peek(self, rows: int, width: int) -> Integers:
        """Numbers of the next rows, (rows, width), without moving on; text files only."""
        end = self.position + rows * width
        return whole(self.values[self.position : end], self.what).reshape(rows, width)

    def _take(self, count: int, kind: str) -> NDArray:
        if self.binary:
            dtype = np.dtype(kind)
            return self._bytes(count, dtype.newbyteorder() if self.swap else dtype)
        self._require_count(count)
        end = self.position + count
        if end > len(self.values):
            raise self._short(f"{end} numbers are announced, {len(self.values)} are there")
        taken = self.values[self.position : end]
        self.position = end
        return taken if kind == "f8" else whole(taken, self.what)

    def _bytes(self, count: int, dtype: np.dtype) -> NDArray:
        self._require_count(count)
        end = self.position + count * dtype.itemsize
        if end > len(self.body):
            raise self._short(f"{end} bytes are announced, {len(self.body)} are there")
        taken = np.frombuffer(self.body, dtype=dtype, count=count, offset=self.position)
        self.position = end
        return taken

    def _require_count(self, count: int) -> None:
        if count < 0:
            raise MeshError(f"{self.what} holds the negative count {count}; save the mesh again")

    def _short(self, figures: str) -> MeshError:
        return MeshError(f"{self.what} ends too early: {figures}; save or copy the file again")


def text_numbers(body: bytes | str, what: str) -> NDArray[np.float64]:
    """All numbers of a text separated by white space, (k,)."""
    text = body.decode("latin-1") if isinstance(body, bytes) else body
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    word = next((w for w in text.split() if not _NUMBER.fullmatch(w)), "")
    raise MeshError(f"{what} holds {word[:40]!r} where a number is expected; save the mesh again")


_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.I)


def whole(values: NDArray[np.float64], what: str) -> Integers:
    """Numbers of a text as integers, refused if they are not."""
    if not np.all(np.abs(values) < 2.0**53) or np.any(values != np.trunc(values)):
        bad = values[~(np.abs(values) < 2.0**53) | (values != np.trunc(values))][0]
        raise MeshError(f"{what} holds {bad:.12g} where a whole number is expected; save it again")
    return values.astype(np.int64)
