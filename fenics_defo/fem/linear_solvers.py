"""Solvers of one symmetric system after another on the same mesh: direct, and conjugate gradients.

Each keeps between two matrices what depends on the pattern of their entries only.
"""

import logging
from typing import Literal, Protocol, get_args

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError, SolverError
from fenics_defo.fem.assembly import Assembly
from fenics_defo.fem.gradients import INFINITE, JacobiGradients, MultigridGradients
from fenics_defo.fem.linalg import Factorization

Array = NDArray[np.float64]
Kind = Literal["cholesky", "pcg-jacobi", "pcg-amg"]

_log = logging.getLogger(__name__)


class LinearSolver(Protocol):
    """Solver of K x = b for one symmetric matrix after another; collective throughout."""

    @property
    def iterations(self) -> int:
        """Iterations of the last solve; 1 for a direct solver."""

    def prepare(self, matrix: PETSc.Mat) -> None:
        """Take a matrix of `Assembly.empty_matrix`'s pattern.

        Its held rows hold no more than their diagonal, which the solver may change.

        Raises:
            SolverError: the matrix is singular or not finite, or memory ran out.
        """

    def solve(self, right_side: Array) -> Array:
        """Solution (owned dofs,) for a right-hand side (owned dofs,), zero at held components.

        Raises:
            SolverError: the iteration did not converge, or the matrix is not positive definite.
        """

    def close(self) -> None:
        """Free what PETSc holds."""


def linear_solver(
    kind: Kind, assembly: Assembly, *, tolerance: float = 1e-6, iterations: int = 10_000
) -> LinearSolver:
    """A solver for matrices of one body.

    Args:
        kind: "cholesky": MUMPS's factors, the order of elimination found once; "pcg-jacobi":
            conjugate gradients preconditioned by the 3x3 blocks of the diagonal; "pcg-amg":
            conjugate gradients with an algebraic multigrid that knows the rigid motions.
        assembly: the body's.
        tolerance: the iteration stops when √(rᵀ P r) of the residual r, with P the preconditioner,
            has fallen to this part of its beginning [-].
        iterations: largest number of iterations of one solve.

    Raises:
        DefoError: ``kind`` or ``tolerance`` is none of the allowed.
    """
    if kind not in get_args(Kind):
        raise DefoError(f"the linear solver must be one of {get_args(Kind)}, got {kind!r}")
    if not 0.0 < tolerance < 1.0:
        raise DefoError(
            f"the linear solver's tolerance must lie between 0 and 1, got {tolerance!r}; "
            "1e-6 is usual"
        )
    if kind == "cholesky":
        return Cholesky()
    if kind == "pcg-jacobi":
        return JacobiGradients(assembly, tolerance=tolerance, iterations=iterations)
    return MultigridGradients(assembly, tolerance=tolerance, iterations=iterations)


class Cholesky:
    """MUMPS's factors; of an indefinite matrix L D Lᵀ instead, as the log warns.

    The order of elimination is found for the first matrix and kept.
    """

    def __init__(self) -> None:
        self._factors: Factorization | None = None
        self._definite = True  # whether the factors are those of a definite matrix
        self.iterations = 1
        #: Number of negative eigenvalues of the last matrix.
        self.negative_eigenvalues = 0

    def prepare(self, matrix: PETSc.Mat) -> None:
        """Factorise a matrix, which need not be kept."""
        if not np.isfinite(matrix.norm(PETSc.NormType.FROBENIUS)):
            raise SolverError(INFINITE)
        definite = self.negative_eigenvalues == 0
        negative = self._factorise(matrix, definite=definite)
        if definite and negative:
            _log.warning(
                "the stiffness has %d negative eigenvalues: it is factorised as L D L^T", negative
            )
            self._factorise(matrix, definite=False)
        self.negative_eigenvalues = negative

    def _factorise(self, matrix: PETSc.Mat, *, definite: bool) -> int:
        if self._factors is not None and self._definite == definite:
            factors, self._factors = self._factors, None  # closed, should it fail
            factors.refactorise(matrix)
        else:
            self.close()
            factors = Factorization(matrix, definite=definite)
        self._factors, self._definite = factors, definite
        return factors.negative_pivots

    def solve(self, right_side: Array) -> Array:
        """Solve for one right-hand side (owned dofs,), zero at held components."""
        assert self._factors is not None, "prepare a matrix first"
        return self._factors.solve(np.reshape(right_side, (-1, 1), order="F"))[:, 0]

    def close(self) -> None:
        """Free the factors; collective."""
        if self._factors is not None:
            self._factors.close()
            self._factors = None
