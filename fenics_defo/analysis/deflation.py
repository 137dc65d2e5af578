"""Elastic modes of a body that is free to move: its strainless motions are known, and left out.

With R the strainless motions (K R = 0, Rᵀ M R = I) and S springs of any stiffness at as many
components as R has columns, K + S is positive definite, and K y = f has the solution
(K + S)⁻¹ f whenever Rᵀ f = 0: a load in equilibrium bends the springs not at all. So the operator

    P (K + S)⁻¹ M,   P = I - R Rᵀ M,

has the elastic eigenpairs (1/λ, φ) and no others. No shift is needed, whose distance to the first
elastic λ would have to be guessed; and the strainless motions are exact.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.eigenpairs import BLOCK, EigenProblem, Pairs
from fenics_defo.analysis.lanczos import block_lanczos
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.stability import not_stable
from fenics_defo.fem.linalg import Factorization, multiply
from fenics_defo.fem.multigrid import MultigridSolver

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FreeBody:
    """The eigenvalue problem of a body with strainless motions.

    Args:
        problem: its matrices, shift 0.
        motions: R (owned dofs, k) in Fortran order, orthonormal in M.
        momenta: M R (owned dofs, k).
        supports: (owned dofs,) bool, where the springs are.
    """

    problem: EigenProblem
    motions: Array
    momenta: Array
    supports: NDArray[np.bool_]

    @property
    def elastic(self) -> int:
        """Number of elastic modes."""
        return self.problem.independent - self.motions.shape[1]

    @contextmanager
    def supported(self) -> Iterator[PETSc.Mat]:
        """K + S, the springs as stiff as the body's own diagonal."""
        matrix = self.problem.shifted(0.0)
        try:
            diagonal = matrix.getDiagonal()
            diagonal.array[~self.supports] = 0.0
            matrix.setDiagonal(diagonal, addv=PETSc.InsertMode.ADD_VALUES)
            matrix.assemble()
            diagonal.destroy()
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            yield matrix
        finally:
            matrix.destroy()

    def deflated(self, block: Array) -> Array:
        """P X: a block (owned dofs, b) without its strainless part, in Fortran order."""
        return block - self.motions @ self.problem.products(self.momenta, block)

    def balanced(self, block: Array) -> Array:
        """Pᵀ X: loads without resultant."""
        return block - self.momenta @ self.problem.products(self.motions, block)

    def with_motions(self, elastic: Pairs) -> Pairs:
        """All pairs: the strainless motions with λ = 0, then the elastic ones."""
        values = np.append(np.zeros(self.motions.shape[1]), elastic.values)
        return Pairs(values, np.asfortranarray(np.hstack([self.motions, elastic.vectors])))

    def lanczos(self, count: int, *, tolerance: float, seed: int, phases: Phases) -> Pairs:
        """At least ``count`` elastic pairs by block Lanczos with MUMPS's factors of K + S.

        Raises:
            SolverError: no memory.
            EigenSolveError: they did not converge, or the state is not stable.
        """
        with phases("factorise"), self.supported() as matrix:
            factors = Factorization(matrix, definite=self.problem.definite)
        with factors, phases("solve"):
            if not self.problem.definite and factors.negative_pivots:
                raise not_stable(factors.negative_pivots)
            return self._block_lanczos(factors, count, tolerance=tolerance, seed=seed)

    def multigrid_lanczos(
        self, count: int, near_kernel: Array, *, tolerance: float, seed: int, phases: Phases
    ) -> Pairs:
        """The same with conjugate gradients and multigrid in place of the factors.

        Raises:
            SolverError: an inner solve did not converge.
            EigenSolveError: the pairs did not converge.
        """
        with phases("factorise"), self.supported() as matrix:
            solver = MultigridSolver(matrix, near_kernel, self.problem.free, rtol=0.01 * tolerance)
        with solver, phases("solve"):
            pairs = self._block_lanczos(solver, count, tolerance=tolerance, seed=seed)
            return self.problem.ritz(self.deflated(pairs.vectors))

    def _block_lanczos(
        self, solver: Factorization | MultigridSolver, count: int, *, tolerance: float, seed: int
    ) -> Pairs:
        problem = self.problem
        rng = np.random.default_rng([seed, problem.comm.rank])
        width = min(BLOCK, self.elastic)
        found = block_lanczos(
            lambda block: self.deflated(solver.solve(np.asfortranarray(self.balanced(block)))),
            lambda block: multiply(problem.mass, block),
            lambda: problem.random_block(rng, width),
            count,
            comm=problem.comm,
            independent=self.elastic,
            tolerance=tolerance,
        )
        return Pairs(1.0 / found.theta, found.vectors)


def orthonormal_in_mass(problem: EigenProblem, fields: Array) -> tuple[Array, Array]:
    """Independent fields (owned dofs, k) made orthonormal in M, and their products with M.

    Returns:
        R and M R, (owned dofs, k) in Fortran order, the same span.
    """
    for _ in range(2):  # the second time removes what the first one's round-off left
        products = problem.products(fields, multiply(problem.mass, fields))
        scale = 1.0 / np.sqrt(np.diag(products))
        values, turn = np.linalg.eigh(products * np.outer(scale, scale))
        fields = np.asfortranarray(fields @ (scale[:, None] * turn / np.sqrt(values)))
    return fields, multiply(problem.mass, fields)
