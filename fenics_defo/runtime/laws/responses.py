"""Laws with kernels of their own, behind what a force law asks of any material."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.response import PointResponse

type Array = NDArray[np.float64]


class ResponseKernel:
    """A law that answers for gradients (n, 3, 3) at once; see `PointKernel`.

    Args:
        respond: takes gradients (n, 3, 3), whether the tangent is wanted, and arrays to write into.
        count: number of points n.
    """

    def __init__(self, respond: Callable[[Array, bool, PointResponse], object], count: int) -> None:
        self.gradients: Array = np.zeros((9, count))
        self._respond = respond
        self._bent = PointResponse.empty(count, tangent=True)
        self._plain = PointResponse(self._bent.energy, self._bent.stress, None)
        self._stress = np.zeros((9, count))

    def energy(self) -> Array:
        """ψ (n,) [J/m³]."""
        self._respond(self._points, False, self._plain)
        return self._bent.energy

    def stress(self) -> Array:
        """P (9, n) [Pa]."""
        self._respond(self._points, False, self._plain)
        return self._stresses()

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa]."""
        self._respond(self._points, True, self._bent)
        assert self._bent.tangent is not None
        return self._stresses(), self._bent.tangent.reshape(-1, 9, 9)

    @property
    def _points(self) -> Array:
        return np.ascontiguousarray(self.gradients.T).reshape(-1, 3, 3)

    def _stresses(self) -> Array:
        self._stress[:] = self._bent.stress.reshape(-1, 9).T
        return self._stress
