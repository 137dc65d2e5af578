"""The matrices of an eigenvalue problem and the solvers that find its lowest pairs."""

from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import scipy.linalg
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
        vectors: X (owned dofs, k) in Fortran order, orthonormal in M.
        forces: K X (owned dofs, k).
        momenta: M X (owned dofs, k).
        converged: how many, from the first, are accurate; the rest show what comes next.
    """

    values: Array
    vectors: Array
    forces: Array
    momenta: Array
    converged: int

    def leading(self, count: int) -> "Pairs":
        """The first pairs only."""
        return Pairs(
            self.values[:count],
            self.vectors[:, :count],
            self.forces[:, :count],
            self.momenta[:, :count],
            min(self.converged, count),
        )

    def rotated(self, rotation: Array) -> "Pairs":
        """Vectors combined by an orthogonal matrix (k, k) that mixes equal eigenvalues only."""
        return Pairs(
            self.values,
            np.asfortranarray(self.vectors @ rotation),
            self.forces @ rotation,
            self.momenta @ rotation,
            self.converged,
        )


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
                f"the given displacement is not a stable state: the tangent has {unstable} "
                f"negative eigenvalue{'s' if unstable > 1 else ''}, and modes exist about stable "
                "equilibria only. "
                "Lower the load below buckling, or converge the equilibrium"
            )
        return factors

    def random_block(self, rng: np.random.Generator, width: int) -> Array:
        """Random vectors that are zero at held components."""
        block = np.asfortranarray(rng.standard_normal((len(self.free), width)))
        block[~self.free] = 0.0
        return block

    def lanczos(
        self, count: int, *, guard: int, tolerance: float, seed: int, phases: Phases
    ) -> Pairs:
        """Pairs by block Lanczos with MUMPS's factors; at least ``count`` and some guards."""
        with phases("factorise"):
            factors = self.factorised()
        with factors, phases("solve"):
            return self._block_lanczos(
                factors.solve, count, guard=guard, tolerance=tolerance, seed=seed
            )

    def multigrid_lanczos(
        self,
        count: int,
        near_kernel: Array,
        *,
        guard: int,
        tolerance: float,
        seed: int,
        phases: Phases,
    ) -> Pairs:
        """Pairs by block Lanczos with multigrid-preconditioned inner solves."""
        matrix = self.shifted(self.shift)
        try:
            with phases("factorise"):
                solver = MultigridSolver(matrix, near_kernel, self.free, rtol=1e-4 * tolerance)
        finally:
            matrix.destroy()
        with solver, phases("solve"):
            return self._block_lanczos(
                solver.solve, count, guard=guard, tolerance=tolerance, seed=seed
            )

    def _block_lanczos(
        self,
        solve: Callable[[Array], Array],
        count: int,
        *,
        guard: int,
        tolerance: float,
        seed: int,
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
            guard=min(guard, self.independent - count),
            tolerance=tolerance,
        )
        # One inverse iteration more takes from all vectors at once what stiff motions they hold.
        purified = solve(multiply(self.mass, found.vectors)) / found.theta
        return self.ritz(purified, converged=found.converged)

    def below(self, value: float) -> int:
        """Number of eigenvalues below a value, by the inertia of K - value M."""
        matrix = self.shifted(value)
        try:
            with Factorization(matrix, definite=False) as factors:
                return factors.negative_pivots
        finally:
            matrix.destroy()

    def ritz(self, vectors: Array, *, converged: int) -> Pairs:
        """Best pairs in the space of some vectors that are nearly orthonormal in M; collective."""
        vectors = np.asfortranarray(vectors)
        forces, momenta = multiply(self.stiffness, vectors), multiply(self.mass, vectors)
        values, turn = scipy.linalg.eigh(
            self.products(vectors, forces), self.products(vectors, momenta)
        )
        return Pairs(
            values, np.asfortranarray(vectors @ turn), forces @ turn, momenta @ turn, converged
        )

    def residuals(self, pairs: Pairs, floor: float) -> Array:
        """‖K x - λ M x‖ / (max(λ, floor) ‖M x‖) of each pair (k,) [-]; collective."""
        difference = self.norms(pairs.forces - pairs.momenta * pairs.values)
        return difference / (np.maximum(pairs.values, floor) * self.norms(pairs.momenta))

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
