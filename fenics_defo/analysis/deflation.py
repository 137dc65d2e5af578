"""The eigenvalue problem without what is known: strainless motions, and pairs found before.

With R the strainless motions (K R = 0, Rᵀ M R = I) and S springs of any stiffness at as many
components as R has columns, K + S is positive definite, and K y = f has the solution
(K + S)⁻¹ f whenever Rᵀ f = 0: a load in equilibrium bends the springs not at all. So the operator

    P (K + S)⁻¹ M,   P = I - R Rᵀ M,

has the elastic eigenpairs (1/λ, φ) and no others. No shift is needed, whose distance to the first
elastic λ would have to be guessed; and the strainless motions are exact. Pairs found before are
left out by the same projection: blocks of b vectors see b vectors of an eigenvalue at a time.
"""

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.davidson import (
    BLOCK,
    RoughPreconditionerError,
    SearchedProblem,
    block_davidson,
)
from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.ritz_space import combined
from fenics_defo.analysis.stability import not_stable
from fenics_defo.errors import SolverError
from fenics_defo.fem.compat import PETSc
from fenics_defo.fem.linalg import Factorization, Precision, multiply
from fenics_defo.fem.multigrid import MultigridSolver

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

# Largest error of factors in single precision with which the search loses no steps.
_ROUGH = 0.1
# Relative residual of an inner solve by conjugate gradients.
_INNER = 1e-4


@dataclass(frozen=True, slots=True)
class Deflation:
    """An eigenvalue problem and what is left out of it.

    Args:
        problem: the matrices; the shift is 0 if there are strainless motions.
        motions: R (owned dofs, k) in Fortran order, orthonormal in M; k may be 0.
        momenta: M R (owned dofs, k).
        supports: (owned dofs,) bool, where the springs are.
        found: elastic pairs found before.
    """

    problem: EigenProblem
    motions: Array
    momenta: Array
    supports: NDArray[np.bool_]
    found: Pairs | None = None

    @property
    def strainless(self) -> int:
        """Number k of strainless motions."""
        return self.motions.shape[1]

    @property
    def remaining(self) -> int:
        """Dimension of what is left."""
        found = 0 if self.found is None else len(self.found.values)
        return self.problem.independent - self.strainless - found

    def locking(self, pairs: Pairs) -> "Deflation":
        """The same with all converged pairs left out, of which the first k are the motions."""
        known = slice(self.strainless, pairs.converged)
        elastic = Pairs(
            pairs.values[known],
            pairs.vectors[:, known],
            pairs.forces[:, known],
            pairs.momenta[:, known],
            max(0, pairs.converged - self.strainless),
        )
        return replace(self, found=elastic)

    @property
    def known(self) -> tuple[Array, Array]:
        """Vectors (owned dofs, l) that are left out, and their products with M."""
        if self.found is None:
            return self.motions, self.momenta
        vectors = np.hstack([self.motions, self.found.vectors])
        return vectors, np.hstack([self.momenta, self.found.momenta])

    @contextmanager
    def supported(self, shift: float) -> Iterator[PETSc.Mat]:
        """K - shift M + S, the springs as stiff as the body's own diagonal."""
        matrix = self.problem.shifted(shift)
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

    def whole(self, rest: Pairs) -> Pairs:
        """All pairs: the strainless motions with λ = 0, then what was found before and now."""
        if self.found is not None:
            # Guards are not accurate, and nothing above the lowest of them is sure to be complete.
            sure = float(rest.values[rest.converged :].min(initial=np.inf))
            rest = self.problem.ritz(np.hstack([self.found.vectors, rest.vectors]), converged=0)
            rest = replace(rest, converged=int(np.count_nonzero(rest.values < sure * (1 - 1e-6))))
        if not self.strainless:
            return rest
        forces = multiply(self.problem.stiffness, self.motions)
        return Pairs(
            np.append(np.zeros(self.strainless), rest.values),
            np.asfortranarray(np.hstack([self.motions, rest.vectors])),
            np.hstack([forces, rest.forces]),
            np.hstack([self.momenta, rest.momenta]),
            self.strainless + rest.converged,
        )

    def direct(
        self, count: int, *, guard: int, tolerance: float, seed: int, phases: Phases
    ) -> Pairs:
        """At least ``count`` of the remaining pairs and some guards with MUMPS's factors.

        Raises:
            SolverError: no memory.
            EigenSolveError: they did not converge, or the state is not stable.
        """
        search = {"guard": guard, "tolerance": tolerance, "seed": seed}
        if self.problem.definite:
            try:
                return self._direct(count, phases, "single", roughest=_ROUGH, **search)
            except (SolverError, RoughPreconditionerError) as error:
                _log.info("factors in double precision, as those in single fail: %s", error)
        return self._direct(count, phases, "double", **search)

    def _direct(self, count: int, phases: Phases, precision: Precision, **search: Any) -> Pairs:
        problem = self.problem
        with phases("factorise"), self.supported(problem.shift) as matrix:
            factors = Factorization(matrix, definite=problem.definite, precision=precision)
        with closing(factors), phases("solve"):
            if not problem.definite and factors.negative_pivots:
                raise not_stable(factors.negative_pivots)
            return self._block_davidson(factors, count, **search)

    def multigrid(
        self,
        count: int,
        near_kernel: Array,
        *,
        guard: int,
        tolerance: float,
        seed: int,
        phases: Phases,
    ) -> Pairs:
        """The same with conjugate gradients and multigrid in place of the factors.

        Raises:
            SolverError: an inner solve did not converge.
            EigenSolveError: the pairs did not converge.
        """
        with phases("factorise"), self.supported(self.problem.shift) as matrix:
            solver = MultigridSolver(matrix, near_kernel, self.problem.free, rtol=_INNER)
        with closing(solver), phases("solve"):
            return self._block_davidson(solver, count, guard=guard, tolerance=tolerance, seed=seed)

    def _block_davidson(
        self,
        solver: Factorization | MultigridSolver,
        count: int,
        *,
        guard: int,
        tolerance: float,
        seed: int,
        roughest: float = np.inf,
    ) -> Pairs:
        problem = self.problem
        rng = np.random.default_rng([seed, problem.comm.rank])
        width = min(BLOCK, self.remaining)
        vectors, momenta = self.known

        def precondition(block: Array) -> Array:
            if not vectors.shape[1]:
                return solver.solve(block)
            loads = block - combined(momenta, problem.products(vectors, block))
            answer = solver.solve(loads)
            return answer - combined(vectors, problem.products(momenta, answer))

        searched = SearchedProblem(
            precondition=precondition,
            multiply=lambda block: problem.pencil.multiply(block, shift=problem.shift),
            residuals=lambda block, values: problem.pencil.residuals(block, values + problem.shift),
            mass=problem.mass.multiply,
            random=lambda: problem.random_block(rng, width),
            comm=problem.comm,
            independent=self.remaining,
        )
        found = block_davidson(
            searched,
            count,
            guard=min(guard, self.remaining - count),
            tolerance=tolerance,
            roughest=roughest,
        )
        return problem.ritz(found.vectors, converged=found.converged)


def orthonormal_in_mass(problem: EigenProblem, fields: Array) -> tuple[Array, Array]:
    """Independent fields (owned dofs, k) made orthonormal in M, and their products with M.

    Returns:
        R and M R, (owned dofs, k) in Fortran order, the same span.
    """
    if not fields.shape[1]:
        return fields, fields.copy()
    for _ in range(2):  # the second time removes what the first one's round-off left
        products = problem.products(fields, problem.mass.multiply(fields))
        scale = 1.0 / np.sqrt(np.diag(products))
        values, turn = np.linalg.eigh(products * np.outer(scale, scale))
        fields = np.asfortranarray(fields @ (scale[:, None] * turn / np.sqrt(values)))
    return fields, problem.mass.multiply(fields)
