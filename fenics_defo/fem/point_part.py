"""Laws that NumPy evaluates at the quadrature points of their cells."""

from collections.abc import Iterator
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import Corotational, Invertible, PointLaw, PointResponse
from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.cell_points import BATCH, cell_points
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.material_fields import LawRegion

Array = NDArray[np.float64]


class PointPart:
    """∫ ψ(F(u)) dX and its derivatives over the cells of one point law.

    Args:
        space: displacement space.
        region: the law's cells and constants.
        degree: polynomial degree that the quadrature integrates exactly.
    """

    def __init__(self, space: "dolfinx.fem.FunctionSpace", region: LawRegion, degree: int) -> None:
        assert isinstance(region.material, PointLaw)
        self._law = region.material
        self._cells = region.cells[region.cells < space.mesh.topology.index_map(3).size_local]
        quadrature = cell_points(space, self._cells, degree)
        self._loops, self._weights = quadrature.loops, quadrature.weights
        self._points = len(quadrature.points)
        dofs = next(iter(region.parameters.values())).function_space.dofmap.list[self._cells, 0]
        self._parameters = {
            name: np.repeat(field.x.array[dofs], self._points)
            for name, field in region.parameters.items()
        }
        self._positions: NDArray[np.int32] | None = None
        self._batch = max(BATCH // self._points, 1)
        self._gradients = np.empty((self._batch * self._points, 3, 3))
        self._responses: dict[bool, PointResponse] = {}

    def _answers(self, local: Array, *, tangent: bool) -> Iterator[tuple[slice, PointResponse]]:
        """The law's response in some cells after others; the arrays are used again."""
        u = np.ascontiguousarray(local, np.float64)
        if tangent not in self._responses:
            size = len(self._gradients)
            self._responses[tangent] = PointResponse.empty(size, tangent=tangent)
        whole = self._responses[tangent]
        for begin in range(0, len(self._cells), self._batch):
            some = slice(begin, min(begin + self._batch, len(self._cells)))
            points = slice(self._points * some.start, self._points * some.stop)
            count = points.stop - points.start
            F = self._gradients[:count]
            self._loops.gradients(some, u, F)
            response = PointResponse(
                energy=whole.energy[:count],
                stress=whole.stress[:count],
                tangent=None if whole.tangent is None else whole.tangent[:count],
            )
            parameters = {name: values[points] for name, values in self._parameters.items()}
            yield some, self._law.respond(F, parameters, tangent=tangent, out=response)

    def energy(self, local: Array) -> float:
        """This rank's share of the strain energy [J] at a displacement (d, 3) [m]."""
        answers = self._answers(local, tangent=False)
        return sum(float(a.energy @ self._weights[some].ravel()) for some, a in answers)

    def add_force(self, local: Array, force: Array) -> None:
        """Add this rank's share of the internal force to (d, 3) [N]."""
        for some, answer in self._answers(local, tangent=False):
            self._loops.add_forces(some, answer.stress, force)

    def add_tangent(self, local: Array, blocks: BlockMatrix, force: Array | None) -> None:
        """Add this rank's share of the tangent, and of the force where an array is given for it."""
        if self._positions is None:
            self._positions = np.ascontiguousarray(blocks.positions[self._cells])
        for some, answer in self._answers(local, tangent=True):
            assert answer.tangent is not None
            self._loops.add_tangents(some, answer.tangent, self._positions, blocks.values)
            if force is not None:
                self._loops.add_forces(some, answer.stress, force)

    def with_exact_tangent(self) -> "PointPart":
        """The same part, whose tangent is the derivative of its force and nothing better behaved.

        It shares its work arrays with this one.
        """
        other = copy(self)
        if isinstance(self._law, Corotational | Invertible):
            other._law = replace(self._law, tangent="exact")
        return other

    def steepest(self, direction: Array) -> float:
        """Largest entry of the gradient [-] of a displacement (d, 3) in this rank's cells."""
        u, largest = np.ascontiguousarray(direction, np.float64), 0.0
        for begin in range(0, len(self._cells), self._batch):
            some = slice(begin, min(begin + self._batch, len(self._cells)))
            F = self._gradients[: self._points * (some.stop - some.start)]
            self._loops.gradients(some, u, F)
            largest = max(largest, float(np.abs(F - np.eye(3)).max()))
        return largest
