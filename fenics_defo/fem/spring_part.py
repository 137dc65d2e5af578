"""Springs between the corners of cells."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MaterialError
from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.cell_kernels import add_blocks
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.material_fields import LawRegion
from fenics_defo.runtime.laws import cell_springs

Array = NDArray[np.float64]


class SpringPart:
    """Σ k/2 (l - L)² over the springs of some cells, and its derivatives.

    A spring between cells of two ranks, or of two regions, is there once for each of them, with
    that one's share of its stiffness.

    Args:
        space: displacement space of order 1.
        region: cells and constants of a `MassSpring` law.

    Raises:
        MaterialError: the displacements are of order 2: nothing would hold the mid nodes.
    """

    def __init__(self, space: "dolfinx.fem.FunctionSpace", region: LawRegion) -> None:
        if space.element.basix_element.degree != 1:
            raise MaterialError(
                "mass-spring bodies have springs between the corners of cells only, so they need "
                "displacements of order 1, got order 2; use order = 1, or another law"
            )
        cells = region.cells[region.cells < space.mesh.topology.index_map(3).size_local]
        self._x = space.tabulate_dof_coordinates()
        young = region.parameters["young"]
        values = young.x.array[young.function_space.dofmap.list[cells, 0]]
        springs = cell_springs(self._x, space.dofmap.list[cells], values)
        self._ends = springs.ends.astype(np.int32)
        self._length, self._stiffness = springs.length, springs.stiffness
        self._positions: NDArray[np.int32] | None = None

    def _stretched(self, local: Array) -> tuple[Array, Array]:
        """Vectors along the springs (e, 3) and their lengths (e,) [m]."""
        along = np.subtract(*((self._x + local)[self._ends[:, k]] for k in (1, 0)))
        return along, np.sqrt(np.einsum("ej,ej->e", along, along))

    def energy(self, local: Array) -> float:
        """This rank's share of the strain energy [J] at a displacement (d, 3) [m]."""
        _, length = self._stretched(local)
        return float(0.5 * self._stiffness @ (length - self._length) ** 2)

    def add_force(self, local: Array, force: Array) -> None:
        """Add this rank's share of the internal force to (d, 3) [N]."""
        self._add_force(*self._stretched(local), force)

    def _add_force(self, along: Array, length: Array, force: Array) -> None:
        pull = (self._stiffness * _one_less(self._length, length))[:, None] * along
        for component in range(3):
            for end, sign in ((1, 1.0), (0, -1.0)):
                force[:, component] += sign * np.bincount(
                    self._ends[:, end], weights=pull[:, component], minlength=len(force)
                )

    def add_tangent(self, local: Array, blocks: BlockMatrix, force: Array | None) -> None:
        """Add this rank's share of the tangent, and of the force where an array is given for it."""
        if self._positions is None:
            self._positions = np.ascontiguousarray(blocks.positions_of(self._ends).reshape(-1, 4).T)
        along, length = self._stretched(local)
        if force is not None:
            self._add_force(along, length, force)
        # k (1 - L/l) I + k L/l t tᵀ with t the unit vector along the spring
        transverse = self._stiffness * _one_less(self._length, length)
        unit = along / np.where(length > 0.0, length, 1.0)[:, None]
        stiffness = np.einsum("e,ei,ej->eij", self._stiffness - transverse, unit, unit)
        stiffness[:, range(3), range(3)] += transverse[:, None]
        for same in (0, 3):
            add_blocks(self._positions[same], stiffness, blocks.values)
        np.negative(stiffness, out=stiffness)
        for other in (1, 2):
            add_blocks(self._positions[other], stiffness, blocks.values)

    def with_exact_tangent(self) -> "SpringPart":
        """This part."""
        return self

    def steepest(self, direction: Array) -> float:
        """Largest change of a spring's vector along a displacement (d, 3), by its length [-]."""
        change = np.subtract(*(direction[self._ends[:, k]] for k in (1, 0)))
        return float((np.abs(change).max(axis=1) / self._length).max(initial=0.0))


def _one_less(rest: Array, length: Array) -> Array:
    """1 - L/l; 1 for a spring of no length, which has no direction to push in."""
    return 1.0 - rest / np.where(length > 0.0, length, np.inf)
