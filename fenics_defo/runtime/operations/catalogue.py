"""The operations that a list may name: functions of numbers, entry by entry."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation.

    Args:
        code: its number in model files, which never changes.
        arity: number of operands.
        function: takes the operands, arrays that broadcast, and ``out``.
    """

    code: int
    arity: int
    function: Callable[..., Any]


def _where(
    condition: NDArray[Any], yes: NDArray[Any], no: NDArray[Any], out: NDArray[Any]
) -> NDArray[Any]:
    """``yes`` where the condition is not zero; NaN in the other branch does no harm."""
    np.copyto(out, np.where(condition != 0.0, yes, no))
    return out


#: By name. Conditions are 1 and 0.
OPERATIONS = {
    "add": Operation(1, 2, np.add),
    "subtract": Operation(2, 2, np.subtract),
    "multiply": Operation(3, 2, np.multiply),
    "divide": Operation(4, 2, np.divide),
    "negative": Operation(5, 1, np.negative),
    "square": Operation(6, 1, np.square),
    "reciprocal": Operation(7, 1, np.reciprocal),
    "power": Operation(8, 2, np.power),
    "sqrt": Operation(9, 1, np.sqrt),
    "exp": Operation(10, 1, np.exp),
    "log": Operation(11, 1, np.log),
    "absolute": Operation(12, 1, np.absolute),
    "sign": Operation(13, 1, np.sign),
    "minimum": Operation(14, 2, np.minimum),
    "maximum": Operation(15, 2, np.maximum),
    "sin": Operation(16, 1, np.sin),
    "cos": Operation(17, 1, np.cos),
    "tan": Operation(18, 1, np.tan),
    "arcsin": Operation(19, 1, np.arcsin),
    "arccos": Operation(20, 1, np.arccos),
    "arctan": Operation(21, 1, np.arctan),
    "arctan2": Operation(22, 2, np.arctan2),
    "sinh": Operation(23, 1, np.sinh),
    "cosh": Operation(24, 1, np.cosh),
    "tanh": Operation(25, 1, np.tanh),
    "less": Operation(26, 2, np.less),
    "less_equal": Operation(27, 2, np.less_equal),
    "greater": Operation(28, 2, np.greater),
    "greater_equal": Operation(29, 2, np.greater_equal),
    "equal": Operation(30, 2, np.equal),
    "not_equal": Operation(31, 2, np.not_equal),
    "logical_and": Operation(32, 2, np.logical_and),
    "logical_or": Operation(33, 2, np.logical_or),
    "logical_not": Operation(34, 1, np.logical_not),
    "where": Operation(35, 3, _where),
}

#: Names by number.
BY_CODE = {operation.code: name for name, operation in OPERATIONS.items()}

#: The most operands that any operation has.
WIDTH = 3
