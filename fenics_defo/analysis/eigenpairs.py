"""The matrices of an eigenvalue problem and the solvers that find its lowest pairs."""

from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.lanczos import block_lanczos
from fenics_defo.analysis.phases import Phases
from fenics_defo.errors import EigenSolveError
from fenics_defo.fem.linalg import Factorization, multiply
from fenics_defo.fem.multigrid import MultigridSolver

Array = NDArray[np.float64]

#: Vectors that are solved for at once: more reads the factors less often, and needs more vectors in
#: all.
BLOCK = 4


@dataclass(frozen=True, slots=True)
class Pairs:
    """Eigenpairs over this rank's owned dofs.

    Args:
        values: λ (k,) [rad²/s²], ascending.
        vectors: (owned dofs, k) in Fortran order, orthonormal in M.
    """

    values: Array
    vectors: Array


@dataclass
class EigenProblem:
    """K x = λ M x with K symmetric and M positive semidefinite; owns its matrices. Use in ``with``.

    Args:
        stiffness: K [N/m], held rows with a positive diagonal.
        mass: M [kg], held rows zero.
        shift: σ [rad²/s²], at or below the wanted λ.
        definite: whether K - σ M is known to be positive definite.
        independent: number of components that are not held.
        free: (owned dofs,) bool, components that are not held.
    """

    stiffness: PETSc.Mat
    mass: PETSc.Mat
    shift: float
    definite: bool
    independent: int
    free: NDArray[np.bool_]

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the matrices."""
        return self.stiffness.getComm().tompi4py()

    def shifted(self, shift: float) -> PETSc.Mat:
        """K - shift M as a new matrix; the caller destroys it."""
        matrix = self.stiffness.copy()
        if shift:
            matrix.axpy(-shift, self.mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return matrix

    def factorised(self) -> Factorization:
        """Factors of K - σ M.

        Raises:
            SolverError: no memory, or singular.
            EigenSolveError: eigenvalues lie below the shift, so that the state is not stable.
        """
        matrix = self.shifted(self.shift)
        try:
            factors = Factorization(matrix, definite=self.definite)
        finally:
            matrix.destroy()
        if not self.definite and factors.negative_pivots:
            unstable = factors.negative_pivots
            factors.close()
            raise EigenSolveError(
                f"the given displacement is not a stable state: the tangent has {unstable} negative "
                f"eigenvalue{'s' if unstable > 1 else ''}; modes exist about stable equilibria only. "
                "Lower the load below buckling, or converge the equilibrium"
            )
        return factors

    def random_block(self, rng: np.random.Generator, width: int) -> Array:
        """Random vectors that are zero at held components."""
        block = np.asfortranarray(rng.standard_normal((len(self.free), width)))
        block[~self.free] = 0.0
        return block

    def lanczos(self, count: int, *, tolerance: float, seed: int, phases: Phases) -> Pairs:
        """Pairs by block Lanczos with MUMPS's factors; at least ``count`` of them."""
        with phases("factorise"):
            factors = self.factorised()
        with factors, phases("solve"):
            return self._block_lanczos(factors.solve, count, tolerance=tolerance, seed=seed)

    def multigrid_lanczos(
        self, count: int, near_kernel: Array, *, tolerance: float, seed: int, phases: Phases
    ) -> Pairs:
        """Pairs by block Lanczos with multigrid-preconditioned inner solves, for bodies of any
        size."""
        matrix = self.shifted(self.shift)
        try:
            with phases("factorise"):
                solver = MultigridSolver(matrix, near_kernel, self.free, rtol=0.01 * tolerance)
        finally:
            matrix.destroy()
        with solver, phases("solve"):
            pairs = self._block_lanczos(solver.solve, count, tolerance=tolerance, seed=seed)
            return self.ritz(pairs.vectors)

    def _block_lanczos(
        self, solve: Callable[[Array], Array], count: int, *, tolerance: float, seed: int
    ) -> Pairs:
        rng = np.random.default_rng([seed, self.comm.rank])
        width = min(BLOCK, self.independent)
        found = block_lanczos(
            solve,
            lambda block: multiply(self.mass, block),
            lambda: self.random_block(rng, width),
            count,
            comm=self.comm,
            independent=self.independent,
            tolerance=tolerance,
        )
        return Pairs(self.shift + 1.0 / found.theta, found.vectors)

    def below(self, value: float) -> int:
        """Number of eigenvalues below a value, by the inertia of K - value M (one more
        factorisation)."""
        matrix = self.shifted(value)
        try:
            with Factorization(matrix, definite=False) as factors:
                return factors.negative_pivots
        finally:
            matrix.destroy()

    def ritz(self, vectors: Array) -> Pairs:
        """Best pairs in the space of some independent vectors, orthonormal in M to round-off."""
        for _ in range(2):
            values, turn = np.linalg.eigh(self.products(vectors, multiply(self.mass, vectors)))
            vectors = np.asfortranarray(vectors @ (turn / np.sqrt(values)))
        values, turn = np.linalg.eigh(self.products(vectors, multiply(self.stiffness, vectors)))
        return Pairs(values, np.asfortranarray(vectors @ turn))

    def residuals(self, pairs: Pairs, floor: float) -> Array:
        """‖K x - λ M x‖ / (max(λ, floor) ‖M x‖) of each pair (k,) [-]; collective."""
        forces = multiply(self.stiffness, pairs.vectors)
        inertia = multiply(self.mass, pairs.vectors)
        difference = self.norms(forces - inertia * pairs.values)
        return difference / (np.maximum(pairs.values, floor) * self.norms(inertia))

    def norms(self, block: Array) -> Array:
        """Euclidean norm of each column over all ranks."""
        squares = np.einsum("ij,ij->j", block, block)
        self.comm.Allreduce(MPI.IN_PLACE, squares, op=MPI.SUM)
        return np.sqrt(squares)

    def products(self, left: Array, right: Array) -> Array:
        """leftᵀ right over all ranks."""
        result = np.ascontiguousarray(left.T @ right)
        self.comm.Allreduce(MPI.IN_PLACE, result, op=MPI.SUM)
        return result

    def close(self) -> None:
        """Free the matrices; collective."""
        self.stiffness.destroy()
        self.mass.destroy()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
