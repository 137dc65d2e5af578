"""Energies of the deformation gradient at a batch of points, from a list of operations."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.operations import Machine, OperationList

type Array = NDArray[np.float64]

_ROWS, _COLUMNS = np.triu_indices(9)


class GeneralKernel:
    """ψ(F) at n points; see `PointKernel`.

    Args:
        listing: of the nine entries of F and the parameters; gives ψ, its nine derivatives, and the
            45 second ones on and above the diagonal, row by row.
        parameters: (n,) or a number for each further input.
        count: number of points n.
    """

    def __init__(
        self, listing: OperationList, parameters: Sequence[Array | float], count: int
    ) -> None:
        given = dict(enumerate(parameters, start=9))
        self._curved = Machine(listing, (count,), given)
        self._sloped = Machine(listing.first_outputs(10), (count,), given)
        self._level = Machine(listing.first_outputs(1), (count,), given)
        self.gradients: Array = np.zeros((9, count))
        self._tangent = np.zeros((count, 9, 9))

    def energy(self) -> Array:
        """ψ (n,) [J/m³]."""
        self._level.inputs[:] = self.gradients
        return self._level.run()[0]

    def stress(self) -> Array:
        """P (9, n) [Pa]."""
        self._sloped.inputs[:] = self.gradients
        return self._sloped.run()[1:]

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa]."""
        self._curved.inputs[:] = self.gradients
        outputs = self._curved.run()
        second = outputs[10:].T
        self._tangent[:, _ROWS, _COLUMNS] = second
        self._tangent[:, _COLUMNS, _ROWS] = second
        return outputs[1:10], self._tangent
