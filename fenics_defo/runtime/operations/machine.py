"""Running a list of operations on arrays, with buffers that are made once."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.operations.catalogue import BY_CODE, OPERATIONS
from fenics_defo.runtime.operations.listing import OperationList

Array = NDArray[np.float64]


class Machine:
    """A list of operations made ready for arrays of one shape.

    What depends on parameters alone is computed once; the rest runs without allocation in buffers
    that are used again as soon as nobody needs them.

    Args:
        listing: the operations.
        shape: of each input, such as (points,) or (bodies, points).
        parameters: number of an input -> its value for good, which broadcasts to ``shape``.
    """

    def __init__(
        self, listing: OperationList, shape: tuple[int, ...], parameters: Mapping[int, Any]
    ) -> None:
        #: (open inputs, *shape): where a caller puts the inputs that are no parameters, in order.
        self.inputs: Array = np.zeros((listing.inputs - len(parameters), *shape))
        #: (outputs, *shape): the results of the last `run`.
        self.outputs: Array = np.zeros((listing.outputs.size, *shape))
        self._shape = shape
        opened = iter(self.inputs)
        self._fixed: dict[int, Array] = {}
        values: dict[int, Array] = {}
        for place in range(listing.inputs):
            if place in parameters:
                self._fixed[place] = np.asarray(parameters[place], np.float64)
            else:
                values[place] = next(opened)
        for place, constant in enumerate(listing.constants, start=listing.inputs):
            self._fixed[place] = np.array(constant)
        self._steps: list[tuple[Any, ...]] = []
        self._plan(listing, values)

    def run(self) -> Array:
        """Results (outputs, *shape) of what `inputs` holds; overwritten by the next run."""
        for function, arguments, out in self._steps:
            function(*arguments, out=out)
        return self.outputs

    def _plan(self, listing: OperationList, values: dict[int, Array]) -> None:
        """Give each operation its buffers; compute at once what never changes."""
        first = listing.inputs + listing.constants.size
        rows = {int(value): row for row, value in enumerate(listing.outputs)}
        operations = list(_operations(listing, first))
        last = {operand: place for place, _, operands in operations for operand in operands}
        free: list[Array] = []
        with np.errstate(all="ignore"):
            for place, function, operands in operations:
                taken = [self._fixed[o] if o in self._fixed else values[o] for o in operands]
                if all(operand in self._fixed for operand in operands):
                    shape = np.broadcast_shapes(*(np.shape(array) for array in taken))
                    self._fixed[place] = function(*taken, out=np.empty(shape))
                    continue
                if place in rows:
                    target = self.outputs[rows[place]]
                else:
                    target = free.pop() if free else np.empty(self._shape)
                values[place] = target
                self._steps.append((function, taken, target))
                free += [
                    values[operand]
                    for operand in set(operands)
                    if operand in values and operand not in rows
                    if first <= operand and last[operand] == place
                ]
        self._keep_results(listing, values, rows)

    def _keep_results(
        self, listing: OperationList, values: dict[int, Array], rows: dict[int, int]
    ) -> None:
        """Outputs that never change, that are inputs, or that are named twice."""
        for row, place in enumerate(listing.outputs.tolist()):
            if place in self._fixed:
                self.outputs[row] = self._fixed[place]
            elif row != rows[place] or place < listing.inputs:
                self._steps.append((np.positive, (values[place],), self.outputs[row]))


def evaluate(listing: OperationList, inputs: Sequence[Array | float]) -> list[Array]:
    """Outputs of a list for inputs that broadcast to one shape, which may differ at each call."""
    shape = np.broadcast_shapes(*(np.shape(value) for value in inputs))
    values = [np.asarray(value, np.float64) for value in inputs]
    values += [np.asarray(constant) for constant in listing.constants]
    for _, function, operands in _operations(listing, len(values)):
        taken = [values[operand] for operand in operands]
        own = np.broadcast_shapes(*(value.shape for value in taken))
        values.append(function(*taken, out=np.empty(own)))
    return [np.broadcast_to(values[place], shape) for place in listing.outputs.tolist()]


def _operations(
    listing: OperationList, first: int
) -> Iterator[tuple[int, Callable[..., Any], list[int]]]:
    """Number of each result, its function, and the numbers of its operands."""
    rows = zip(listing.codes.tolist(), listing.operands.tolist(), strict=True)
    for place, (code, row) in enumerate(rows, start=first):
        operation = OPERATIONS[BY_CODE[code]]
        yield place, operation.function, row[: operation.arity]
