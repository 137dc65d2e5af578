"""Material constants: a number for the whole region, or a field of one number a cell."""

import reprlib
from collections.abc import Mapping
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MaterialError

type Constant = float | NDArray[np.float64]


def positive(name: str, value: object, *, unit: str) -> Constant:
    """The checked constant ``value``, positive and finite in every cell."""
    return within(name, value, low=0.0, allowed=f"be positive and finite [{unit}]")


def finite(name: str, value: object) -> Constant:
    """The checked constant ``value``, any finite number in every cell."""
    return within(name, value, allowed="be finite")


def within(
    name: str, value: object, *, allowed: str, low: float = -np.inf, high: float = np.inf
) -> Constant:
    """The checked constant ``value``, strictly between ``low`` and ``high`` in every cell.

    Args:
        name: what the user calls the constant.
        value: a real number, or (m,) numbers, one a cell in the order of the mesh file.
        allowed: ends the sentence "``name`` must ..." of the error.
        low: open lower end of the range.
        high: open upper end of the range.

    Returns:
        A float, or a read-only float64 copy (m,) of the field.

    Raises:
        MaterialError: ``value`` is no such number or field, or leaves the range somewhere.
    """
    array = _numbers(name, value)
    outside = ~((array > low) & (array < high))  # NaN is outside of every range
    if np.any(outside):
        with np.errstate(invalid="ignore"):  # inf - inf, for an infinite end of the range
            excess = np.maximum(low - array, array - high)
        excess = np.where(np.isnan(excess), np.inf, excess)
        row = int(np.argmax(np.where(outside, excess, -np.inf)))
        raise MaterialError(f"{name} must {allowed}, got {_where(name, array, row, outside)}")
    if array.ndim == 0:
        return float(array)
    array.flags.writeable = False
    return array


def check_lengths(constants: Mapping[str, Constant]) -> None:
    """Refuse cell fields of different lengths.

    Raises:
        MaterialError: two of ``constants`` are fields with different numbers of cells.
    """
    lengths = {n: np.size(v) for n, v in constants.items() if isinstance(v, np.ndarray)}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise MaterialError(
            f"the cell fields of one material must have equal lengths, but {found} values; "
            "give one value a cell of the same mesh, or one number for all cells"
        )


def store(record: object, constants: Mapping[str, Constant]) -> None:
    """Put checked constants into the frozen ``record``.

    Raises:
        MaterialError: two of them are fields of different lengths.
    """
    check_lengths(constants)
    for name, value in constants.items():
        object.__setattr__(record, name, value)


def equal_by_value(self: object, other: object) -> bool:
    """``==`` of two material records; the one that dataclasses write cannot compare arrays."""
    if type(self) is not type(other):
        return NotImplemented
    return all(
        np.array_equal(getattr(self, field.name), getattr(other, field.name))
        for field in fields(self)  # type: ignore[arg-type]
    )


def hash_by_value(self: object) -> int:
    """Hash that goes with `equal_by_value`."""
    values = (np.asarray(getattr(self, field.name)) for field in fields(self))  # type: ignore[arg-type]
    # Adding zero turns -0.0 into 0.0: the two are equal, so their hashes must be.
    numbers = (value + 0.0 if value.dtype.kind == "f" else value for value in values)
    return hash((type(self), *(value.tobytes() for value in numbers)))


def _numbers(name: str, value: object) -> NDArray[np.float64]:
    """Fresh float64 array () or (m,) of ``value``."""
    problem = MaterialError(
        f"{name} must be one real number, or an array of one number a cell, "
        f"got {reprlib.repr(value)}"
    )
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # a ragged list, for example
        raise problem from None
    if array.dtype.kind not in "iuf" or array.ndim > 1 or array.size == 0:
        raise problem
    return np.array(array, dtype=np.float64)


def _where(
    name: str, array: NDArray[np.float64], row: int, outside: NDArray[np.bool_] | np.bool_
) -> str:
    """The offending value, and for a field also its row."""
    if array.ndim == 0:
        return repr(float(array))
    return (
        f"{name}[{row}] = {float(array[row])!r}, the worst of {np.count_nonzero(outside)} such "
        f"among {array.size} values (rows count from 0, in the order of the mesh file)"
    )
