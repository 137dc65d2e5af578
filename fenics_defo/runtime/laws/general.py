"""Energies of the deformation gradient at a batch of points, from a list of operations."""

from collections.abc import Sequence
from functools import cached_property

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
        self._listing, self._given = listing, given
        self.gradients: Array = np.zeros((9, count))
        self._tangent = np.zeros((count, 9, 9))

    def energy(self) -> Array:
        """ψ (n,) [J/m³]."""
        return self._level.run()[0]

    def stress(self) -> Array:
        """P (9, n) [Pa]."""
        return self._sloped.run()

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa]."""
        outputs = self._curved.run()
        second = outputs[9:].T
        self._tangent[:, _ROWS, _COLUMNS] = second
        self._tangent[:, _COLUMNS, _ROWS] = second
        return outputs[:9], self._tangent

    @cached_property
    def _level(self) -> Machine:
        return self._machine(range(1))

    @cached_property
    def _sloped(self) -> Machine:
        return self._machine(range(1, 10))

    @cached_property
    def _curved(self) -> Machine:
        return self._machine(range(1, 55))

    def _machine(self, outputs: range) -> Machine:
        """What computes some outputs of the list from the gradients."""
        shape = self.gradients.shape[1:]
        return Machine(self._listing.only(outputs), shape, self._given, inputs=self.gradients)
