"""The matrices of implicit steps and what solves with them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.applied_loads import AppliedLoads
from fenics_defo.analysis.constraints import Constraints
from fenics_defo.analysis.minimal_residual import minimal_residual
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import PETSc
from fenics_defo.fem.linalg import combine
from fenics_defo.fem.linear_solvers import Kind, linear_solver

Array = NDArray[np.float64]

# Newton's method gains nothing from a direction that is better.
_SKEW_TOLERANCE = 1e-7
_SKEW_PRODUCTS = 30


@dataclass(frozen=True, slots=True)
class Ahead:
    """β K'(u) v, the change of β K along the velocity, as β / s (K(u + s v) - K(u)).

    Args:
        local: u + s v (d, 3) [m].
        weight: β / s [-].
    """

    local: Array
    weight: float


class Tangents:
    """K, M and a K + b M - dg/du of one body; allocated once, filled again and again; collective.

    Args:
        solid: body.
        constraints: components that are not free.
        linear: linear solver.
        tolerance: of conjugate gradients.
    """

    def __init__(
        self, solid: Solid, constraints: Constraints, linear: Kind, tolerance: float
    ) -> None:
        self._assembly = solid.assembly
        self._stiffness = self._assembly.empty_matrix()
        self._mass = self._assembly.mass.matrix()
        self._effective = self._assembly.empty_matrix()
        self._effective.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self._given, self._product = self._stiffness.createVecs()
        self._rows: NDArray[np.int32] | None = None
        bound = self._assembly
        if constraints.moving:
            first, _ = self._stiffness.getOwnershipRange()
            mine = np.flatnonzero(constraints.prescribed.ravel())
            self._rows = (first + mine).astype(PETSc.IntType)
            bound = self._assembly.with_held(solid.nodes.scatter(constraints.bound))
        self._comm, self._free = solid.comm, constraints.free
        self._follower: PETSc.Mat | None = None
        self._later: PETSc.Mat | None = None
        self._solver = linear_solver(linear, bound, tolerance=tolerance)
        # K of a linear body is filled once, and one solver serves all steps of one length.
        self._constant = solid.is_linear
        self._ready: tuple[float, float] | None = None
        #: Displacement at which K is filled.
        self.filled_at: Array | None = None

    def fill(self, displacement: Array, local: Array) -> Array:
        """Fill K at a displacement (owned nodes, 3), with ghosts ``local`` (d, 3); returns f."""
        if self._constant and self.filled_at is not None:
            force = self._assembly.force(local)
        else:
            self.filled_at = None
            force = self._assembly.linearise(self._stiffness, local)
        self.filled_at = displacement
        return force

    def stiffness_times(self, field: Array) -> Array:
        """K times a field (owned nodes, 3); of held components, the field itself."""
        self._given.array[:] = field.ravel()
        self._stiffness.mult(self._given, self._product)
        return np.array(self._product.array).reshape(-1, 3)

    def diagonal(self) -> Array:
        """Diagonal of K (owned nodes, 3)."""
        self._stiffness.getDiagonal(self._product)
        return np.array(self._product.array).reshape(-1, 3)

    def prepare(
        self,
        scale: float,
        mass_scale: float,
        loads: AppliedLoads,
        time: float,
        local: Array,
        *,
        ahead: Ahead | None = None,
        stiffening: float = 0.0,
    ) -> None:
        """Make the symmetric part of ``scale`` K + ``mass_scale`` M - dg/du ready for `solve`.

        Args:
            scale: of K [-].
            mass_scale: of M [1/s²].
            loads: what gives g.
            time: [s].
            local: displacement (d, 3) [m].
            ahead: adds the change of the damping's stiffness along the velocity.
            stiffening: part of the diagonal that is added to it [-].

        Raises:
            SolverError: it is singular or not finite, or memory ran out.
        """
        plain = ahead is None and not stiffening
        if plain and self._constant and not loads.follows and self._ready == (scale, mass_scale):
            return
        self._ready = None
        effective = self._effective
        weight = 0.0 if ahead is None else ahead.weight
        combine(effective, self._stiffness, scale - weight, self._mass, mass_scale)
        if ahead is not None:
            self._add_ahead(ahead)
        if loads.follows:
            loads.add_tangent(effective, time, local, factor_of_all=-1.0, symmetric=True)
        if self._rows is not None:
            effective.zeroRowsColumns(self._rows, diag=scale)
        if stiffening:
            effective.getDiagonal(self._product)
            self._product.array[:] += stiffening * np.abs(self._product.array)
            effective.setDiagonal(self._product)
        self._solver.prepare(effective)
        self._ready = (scale, mass_scale) if plain else None

    def _add_ahead(self, ahead: Ahead) -> None:
        if self._later is None:
            self._later = self._assembly.empty_matrix()
        self._assembly.fill_tangent(self._later, ahead.local)
        same = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
        self._effective.axpy(ahead.weight, self._later, structure=same)

    def solve(self, right_side: Array) -> tuple[Array, int]:
        """Solution (owned nodes, 3) and iterations; the right-hand side is zero where not free.

        Raises:
            SolverError: the iteration did not converge.
        """
        solution = self._solver.solve(right_side.ravel()).reshape(-1, 3)
        return solution, self._solver.iterations

    def solve_unsymmetric(
        self, right_side: Array, loads: AppliedLoads, time: float, local: Array
    ) -> tuple[Array, int]:
        """As `solve`, with the skew part of dg/du too, which a pressure has where its surface ends.

        GMRES, preconditioned by what `prepare` made ready.
        """
        if self._follower is None:
            self._follower = self._assembly.empty_matrix()
            for option in (PETSc.Mat.Option.SYMMETRY_ETERNAL, PETSc.Mat.Option.SYMMETRIC):
                self._follower.setOption(option, False)
        follower = self._follower
        follower.zeroEntries()
        loads.add_tangent(follower, time, local, factor_of_all=0.5, symmetric=False)
        free, total = self._free, 0

        def operate(field: Array) -> Array:
            nonlocal total
            self._given.array[:] = field.ravel()
            follower.mult(self._given, self._product)
            skew = np.array(self._product.array)
            follower.multTranspose(self._given, self._product)
            skew -= self._product.array
            correction, iterations = self.solve(np.where(free, skew.reshape(-1, 3), 0.0))
            total += iterations
            return field - correction

        begin, total = self.solve(right_side)
        found = minimal_residual(
            operate,
            begin,
            product=lambda one, other: float(self._comm.allreduce(float(np.vdot(one, other)))),
            tolerance=_SKEW_TOLERANCE,
            most=_SKEW_PRODUCTS,
        )
        return found, total

    @property
    def can_tell(self) -> bool:
        """Whether the solver counts negative eigenvalues."""
        return hasattr(self._solver, "negative_eigenvalues")

    @property
    def definite(self) -> bool | None:
        """Whether the last matrix was positive definite; None if the solver cannot tell."""
        negative = getattr(self._solver, "negative_eigenvalues", None)
        return None if negative is None else negative == 0

    def close(self) -> None:
        """Free the matrices; collective."""
        self._solver.close()
        things = [self._stiffness, self._mass, self._effective, self._given, self._product]
        for thing in (*things, self._follower, self._later):
            if thing is not None:
                thing.destroy()
