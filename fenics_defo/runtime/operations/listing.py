"""A list of operations: straight-line code as plain arrays, checked before it runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.operations.catalogue import BY_CODE, OPERATIONS, WIDTH

#: More operations than any material law needs; a longer list is refused.
LONGEST = 20_000
_MOST_INPUTS, _MOST_OUTPUTS = 256, 1024


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OperationList:
    """Outputs as functions of inputs, number by number.

    Values are numbered: the inputs first, then the constants, then the results of the operations in
    their order. An operation takes values of smaller numbers only, so that a list has no cycle.

    Args:
        inputs: number of inputs.
        constants: (c,) finite.
        codes: (k,) operations, see `OPERATIONS`.
        operands: (k, 3) numbers of their operands; -1 where an operation has fewer.
        outputs: (o,) numbers of the values that are the results.

    Raises:
        FileFormatError: an unknown operation, an operand that is not known before, too long a list,
            or arrays that do not fit together.
    """

    inputs: int
    constants: NDArray[np.float64]
    codes: NDArray[np.int64]
    operands: NDArray[np.int64]
    outputs: NDArray[np.int64]

    #: What `from_arrays` needs in an archive.
    SPECS = {  # noqa: RUF012 -- shared by all, as in a class of slots it must be
        "inputs": ArraySpec("iu", 0),
        "constants": ArraySpec("f", 1),
        "codes": ArraySpec("iu", 1),
        "operands": ArraySpec("iu", 2),
        "outputs": ArraySpec("iu", 1),
    }

    def __post_init__(self) -> None:
        for name, dtype in (("constants", np.float64), *((n, np.int64) for n in _INTEGERS)):
            array: NDArray[Any] = np.array(getattr(self, name), dtype=dtype)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        self._check_sizes()
        self._check_operations()

    def _check_sizes(self) -> None:
        length = len(self.codes) if self.codes.ndim == 1 else -1
        if length > LONGEST or self.constants.size > LONGEST:
            raise FileFormatError(
                f"a list of {max(length, self.constants.size)} operations is too long; at most "
                f"{LONGEST} are run"
            )
        if self.operands.shape != (length, WIDTH) or self.constants.ndim != 1:
            raise FileFormatError(
                f"the operands of {length} operations have the shape {self.operands.shape}, "
                f"expected ({length}, {WIDTH})"
            )
        if not 0 <= self.inputs <= _MOST_INPUTS or not 1 <= self.outputs.size <= _MOST_OUTPUTS:
            raise FileFormatError(
                f"a list has {self.inputs} inputs and {self.outputs.size} outputs, expected at "
                f"most {_MOST_INPUTS} and between 1 and {_MOST_OUTPUTS}"
            )
        if self.outputs.ndim != 1 or not np.isfinite(self.constants).all():
            raise FileFormatError("a list's outputs must be numbered, and its constants finite")

    def _check_operations(self) -> None:
        unknown = [int(code) for code in np.unique(self.codes) if int(code) not in BY_CODE]
        if unknown:
            raise FileFormatError(
                f"operation {unknown[0]} is not known; the file was made by a newer version, or "
                "is damaged"
            )
        arity = np.zeros(max(BY_CODE, default=0) + 1, np.int64)
        for operation in OPERATIONS.values():
            arity[operation.code] = operation.arity
        used = np.arange(WIDTH) < arity[self.codes][:, None]
        first = self.inputs + self.constants.size
        own = first + np.arange(len(self.codes))
        known = (self.operands >= 0) & (self.operands < own[:, None])
        if not (known | ~used).all():
            place = int(np.flatnonzero(~(known | ~used).all(axis=1))[0])
            raise FileFormatError(
                f"operation {place} takes a value that is not known before it; a list must not "
                "run in circles"
            )
        operands = np.where(used, self.operands, -1)
        operands.flags.writeable = False
        object.__setattr__(self, "operands", operands)
        if not ((self.outputs >= 0) & (self.outputs < first + len(self.codes))).all():
            raise FileFormatError("an output of a list of operations does not exist")

    def idle_outputs(self) -> NDArray[np.bool_]:
        """(o,) whether an output is zero whatever the inputs are."""
        idle = np.zeros(self.inputs + self.constants.size + self.codes.size, bool)
        idle[self.inputs : self.inputs + self.constants.size] = self.constants == 0.0
        result: NDArray[np.bool_] = idle[self.outputs]
        return result

    def first_outputs(self, count: int) -> "OperationList":
        """The list that computes the first ``count`` outputs and nothing else."""
        first = self.inputs + self.constants.size
        needed = np.zeros(first + self.codes.size, bool)
        needed[self.outputs[:count]] = True
        for place in range(self.codes.size - 1, -1, -1):
            if needed[first + place]:
                operands = self.operands[place]
                needed[operands[operands >= 0]] = True
        kept = needed[first:]
        number = np.arange(needed.size)
        number[first:] = first + np.cumsum(kept) - 1
        return OperationList(
            inputs=self.inputs,
            constants=self.constants,
            codes=self.codes[kept],
            operands=np.where(self.operands >= 0, number[self.operands], -1)[kept],
            outputs=number[self.outputs[:count]],
        )

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The list as arrays, by the names of `SPECS`."""
        return {"inputs": np.array(self.inputs)} | {
            name: getattr(self, name) for name in self.SPECS if name != "inputs"
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The list of `arrays`.

        Raises:
            FileFormatError: see the class.
        """
        values = {name: arrays[name] for name in cls.SPECS if name != "inputs"}
        return cls(inputs=int(arrays["inputs"]), **values)


_INTEGERS = ("codes", "operands", "outputs")
