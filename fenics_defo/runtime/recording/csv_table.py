"""A table of numbers that grows by whole rows: a killed run or a full disk leaves no half row."""

import math
import os
from collections.abc import Sequence
from pathlib import Path

from fenics_defo.errors import DefoError, FileFormatError


class CsvTable:
    """A CSV file with a header, appended to row by row.

    Each row is one write to the system, which keeps it even if the process is killed next; if the
    disk is full the part that was written is cut off again. Numbers are written with the digits
    that give the same float back.

    Args:
        path: the file; created, or replaced if ``size`` is not given.
        columns: names of the columns, without commas, quotes and line breaks.
        size: length [bytes] of the part of an existing file that is kept and continued.

    Raises:
        DefoError: the file cannot be written.
        FileFormatError: the existing file is shorter than ``size``, or has other columns.
    """

    def __init__(
        self, path: str | os.PathLike[str], columns: Sequence[str], *, size: int | None = None
    ) -> None:
        self._path = Path(path)
        self._width = len(columns)
        header = (",".join(columns) + "\n").encode()
        flags = os.O_RDWR | os.O_CREAT | (os.O_TRUNC if size is None else 0)
        try:
            self._file = os.open(self._path, flags, 0o666)
        except OSError as error:
            raise DefoError(
                f"{path}: cannot be written ({error.strerror}); choose another folder."
            ) from error
        self._size = 0
        try:
            if size is None:
                self._write(header)
            else:
                self._resume(header, size)
        except BaseException:
            os.close(self._file)
            raise

    @property
    def size(self) -> int:
        """Length of the file [bytes]."""
        return self._size

    def append(self, values: Sequence[float]) -> None:
        """Write one row.

        Args:
            values: one finite number for each column.

        Raises:
            DefoError: a number is not finite, or the row cannot be written; the file then ends
                with the row before.
        """
        assert len(values) == self._width
        numbers = [float(value) for value in values]
        if not all(map(math.isfinite, numbers)):
            raise DefoError(
                f"{self._path}: a row with NaN or infinity was not written: {numbers!r}; "
                "the computation has diverged, try a smaller step."
            )
        self._write((",".join(map(repr, numbers)) + "\n").encode())

    def sync(self) -> None:
        """Wait until the disk has all rows, which then survive a power cut too.

        Raises:
            DefoError: it does not take them.
        """
        try:
            os.fsync(self._file)
        except OSError as error:
            raise DefoError(
                f"{self._path}: the disk does not take what was written: {error.strerror}; "
                "make room and continue."
            ) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)

    def _write(self, line: bytes) -> None:
        done = 0
        try:
            while done < len(line):
                done += os.pwrite(self._file, line[done:], self._size + done)
        except OSError as error:
            os.ftruncate(self._file, self._size)
            raise DefoError(
                f"{self._path}: writing stopped: {error.strerror}; the rows before are kept, "
                "make room and continue."
            ) from error
        self._size += len(line)

    def _resume(self, header: bytes, size: int) -> None:
        kept = os.pread(self._file, len(header), 0)
        if os.fstat(self._file).st_size < size or kept != header:
            raise FileFormatError(
                f"{self._path}: is not the table that the checkpoint goes with; "
                "run again from the beginning."
            )
        os.ftruncate(self._file, size)
        self._size = size
