"""Mass times motion, and motion from momentum, for consistent and lumped masses."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.instant import StepFailure
from fenics_defo.fem.assembly import Assembly

Array = NDArray[np.float64]

_TOLERANCE = 1e-14
_ITERATIONS = 1000


class Mass(Protocol):
    """M over this rank's own nodes; collective."""

    def apply(self, field: Array) -> Array:
        """M times a field (owned nodes, 3)."""

    def solve(self, momentum: Array, free: NDArray[np.bool_]) -> Array:
        """The field (owned nodes, 3), zero where not free, with M field = momentum where free."""


class LumpedMass:
    """One mass a node.

    Args:
        assembly: the body's.
    """

    def __init__(self, assembly: Assembly) -> None:
        #: (owned nodes, 1) [kg].
        self.nodes: Array = assembly.lumped_mass()[: assembly.owned, None]
        self._known: tuple[NDArray[np.bool_], Array] | None = None

    def apply(self, field: Array) -> Array:
        """M times a field (owned nodes, 3)."""
        return self.nodes * field

    def solve(self, momentum: Array, free: NDArray[np.bool_]) -> Array:
        """The field (owned nodes, 3), zero where not free, with M field = momentum where free."""
        if self._known is None or self._known[0] is not free:
            self._known = (free, np.where(free, 1.0 / self.nodes, 0.0))
        return self._known[1] * momentum


class ConsistentMassOperator:
    """The finite elements' own mass.

    Args:
        assembly: the body's.
    """

    def __init__(self, assembly: Assembly) -> None:
        self._mass, self._comm = assembly.mass, assembly.comm

    def apply(self, field: Array) -> Array:
        """M times a field (owned nodes, 3)."""
        return self._mass.apply(field)

    def solve(self, momentum: Array, free: NDArray[np.bool_]) -> Array:
        """The field (owned nodes, 3), zero where not free, with M field = momentum where free.

        Conjugate gradients, preconditioned by the diagonal: M's condition then depends on the kind
        of the cells only, not on the mesh.
        """
        inverse = np.where(free, 1.0 / self._mass.diagonal()[:, None], 0.0)
        field = np.zeros_like(momentum)
        residual = np.where(free, momentum, 0.0)
        step = inverse * residual
        weight = self._product(residual, step)
        first = weight
        for _ in range(_ITERATIONS):
            if not weight > _TOLERANCE**2 * first:
                break
            image = np.where(free, self._mass.apply(step), 0.0)
            length = weight / self._product(step, image)
            field += length * step
            residual -= length * image
            preconditioned = inverse * residual
            new = self._product(residual, preconditioned)
            step = preconditioned + (new / weight) * step
            weight = new
        if not np.isfinite(first):
            raise StepFailure("the forces are not finite")
        return field

    def _product(self, left: Array, right: Array) -> float:
        return float(self._comm.allreduce(float(np.vdot(left, right))))
