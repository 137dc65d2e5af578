"""A body's displacements, forces and tangents within the span of a few fields."""

from petsc4py import PETSc

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem.assembly import Assembly
from fenics_defo.fem.linalg import multiply
from fenics_defo.fem.solid import Solid

Array = NDArray[np.float64]


class Projection:
    """The fields U_i of u = Σ q_i U_i over this rank's nodes; its methods are collective.

    Args:
        solid: body.
        shapes: U (r, n, 3), nodes in the order of the user's file; the same on each rank.

    Raises:
        DefoError: another shape, or values that are not finite.
    """

    def __init__(self, solid: Solid, shapes: ArrayLike) -> None:
        fields = np.asarray(shapes, dtype=np.float64)
        wanted = (solid.nodes.size, 3)
        if fields.ndim != 3 or fields.shape[1:] != wanted or len(fields) == 0:
            raise DefoError(
                f"the shapes of a reduced body must be (r, {wanted[0]}, 3), one displacement of "
                f"all its nodes for each of r coordinates, got {fields.shape}"
            )
        if not np.isfinite(fields).all():
            raise DefoError("the shapes of a reduced body must be finite, got NaN or infinity")
        self._assembly, self._comm = solid.assembly, solid.comm
        #: (r, d, 3) at this rank's nodes, ghosts last.
        self.fields: Array = np.ascontiguousarray(fields[:, solid.nodes.rows])
        self._rows = self.fields.reshape(len(fields), -1)
        self._own = self._rows[:, : 3 * solid.nodes.owned]

    @property
    def size(self) -> int:
        """Number r of fields."""
        return len(self.fields)

    def displacement(self, q: Array) -> Array:
        """Σ q_i U_i (d, 3) [m] at this rank's nodes."""
        return np.asarray(q @ self._rows).reshape(-1, 3)

    def project(self, force: Array) -> Array:
        """Uᵀ f (r,) of nodal values (d or owned nodes, 3), complete at owned nodes."""
        own = self._own @ force.reshape(-1)[: self._own.shape[1]]
        return self._sum(own)

    def energy(self, q: Array) -> float:
        """Strain energy [J] at q (r,)."""
        return self._assembly.energy(self.displacement(q))

    def force(self, q: Array) -> Array:
        """Uᵀ f(U q) (r,)."""
        return self.project(self._assembly.force(self.displacement(q)))

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Uᵀ f(U q) (r,) and Uᵀ K(U q) U (r, r), the latter made symmetric."""
        free = self._free()
        matrix = free.empty_matrix()
        try:
            force = free.linearise(matrix, self.displacement(q))
            return self.project(force), self._projected(matrix)
        finally:
            matrix.destroy()

    def stiffness_at_rest(self) -> Array:
        """Uᵀ K(0) U (r, r), made symmetric."""
        matrix = self._free().stiffness_matrix()
        try:
            return self._projected(matrix)
        finally:
            matrix.destroy()

    def _free(self) -> Assembly:
        """The body without supports, whose rows are part of K: the fields need not vanish there."""
        return self._assembly.with_held(np.zeros_like(self._assembly.held))

    def _projected(self, matrix: PETSc.Mat) -> Array:
        stiffness = self._sum(self._own @ multiply(matrix, self._own.T))
        return 0.5 * (stiffness + stiffness.T)

    def _sum(self, own: Array) -> Array:
        total = np.empty_like(own)
        self._comm.Allreduce(np.ascontiguousarray(own), total)
        return total
