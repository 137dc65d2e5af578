"""Conjugate gradients for one symmetric system after another on the same mesh."""

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SolverError
from fenics_defo.fem.assembly import Assembly
from fenics_defo.fem.cell_kernels import inverse_blocks
from fenics_defo.fem.linalg import OPTIONS_PREFIX, orthonormal_columns
from fenics_defo.fem.petsc_blocks import block_values, mark_changed

Array = NDArray[np.float64]

_Reason = PETSc.KSP.ConvergedReason
_INDEFINITE = (_Reason.DIVERGED_INDEFINITE_MAT, _Reason.DIVERGED_INDEFINITE_PC)
_NOT_FINITE = (_Reason.DIVERGED_NANORINF, _Reason.DIVERGED_PCSETUP_FAILED)
# A multigrid hierarchy is kept until the iterations are this many times those it began with.
_STALE = 1.5
#: What is said of a matrix that is not finite.
INFINITE = "the stiffness holds NaN or infinity; take a smaller step, and check the loads"


class _Gradients:
    """PETSc's conjugate gradients with vectors that are kept."""

    def __init__(self, *, tolerance: float, iterations: int) -> None:
        self._tolerance, self._most = tolerance, iterations
        self._solver: PETSc.KSP | None = None
        self.iterations = 0

    def _begin(self, matrix: PETSc.Mat, preconditioner: str) -> PETSc.KSP:
        solver = PETSc.KSP().create(matrix.getComm())
        solver.setOptionsPrefix(OPTIONS_PREFIX)
        solver.setType(PETSc.KSP.Type.CG)
        # √(rᵀ P r): no product beyond those CG needs, and each stiffness weighs alike.
        solver.setNormType(PETSc.KSP.NormType.NATURAL)
        solver.setTolerances(rtol=self._tolerance, atol=0.0, max_it=self._most)
        solver.getPC().setType(preconditioner)
        solver.setFromOptions()
        self._right, self._left = matrix.createVecs()
        return solver

    def _set_up(self) -> None:
        assert self._solver is not None
        try:
            self._solver.setUp()
        except PETSc.Error as error:
            raise SolverError(
                f"the stiffness cannot be preconditioned ({error}): a node has none, or it is not "
                "finite; take a smaller step, and check the mesh and the materials"
            ) from error

    def solve(self, right_side: Array) -> Array:
        """Solve for one right-hand side (owned dofs,), zero at held components."""
        assert self._solver is not None, "prepare a matrix first"
        self._left.array[:] = right_side
        try:
            self._solver.solve(self._left, self._right)
        except PETSc.Error as error:
            raise SolverError(f"PETSc could not solve a linear system ({error})") from error
        self.iterations = self._solver.getIterationNumber()
        self._check()
        return np.array(self._right.array)

    def _check(self) -> None:
        assert self._solver is not None
        reason = self._solver.getConvergedReason()
        if reason in _NOT_FINITE:
            matrix, _ = self._solver.getOperators()
            if not np.isfinite(matrix.norm(PETSc.NormType.FROBENIUS)):
                raise SolverError(INFINITE)
        if reason in (*_INDEFINITE, *_NOT_FINITE):
            raise SolverError(
                "conjugate gradients met a matrix that is not positive definite: the body is about "
                "to buckle or a cell to turn inside out; take a smaller step, or the direct solver "
                '(linear = "cholesky")'
            )
        if reason <= 0:
            raise SolverError(
                f"conjugate gradients did not converge in {self.iterations} iterations; use the "
                'direct solver (linear = "cholesky"), or raise their number or the tolerance'
            )

    def close(self) -> None:
        """Free the solver; collective."""
        if self._solver is not None:
            for thing in (self._solver, self._left, self._right):
                thing.destroy()
            self._solver = None


class JacobiGradients(_Gradients):
    """Conjugate gradients preconditioned by the inverse 3x3 blocks of the diagonal.

    Args:
        assembly: the body's, which knows where the blocks lie.
        tolerance: see `linear_solver`.
        iterations: largest number of iterations of one solve.
    """

    def __init__(self, assembly: Assembly, *, tolerance: float, iterations: int) -> None:
        super().__init__(tolerance=tolerance, iterations=iterations)
        self._assembly = assembly
        self._inverse: PETSc.Mat | None = None

    def prepare(self, matrix: PETSc.Mat) -> None:
        """Take a matrix; the caller keeps it alive and unchanged until the last solve with it.

        PETSc 3.25's own preconditioner of this kind keeps the blocks of the first matrix for ever
        if the pattern does not change, so the blocks are inverted here.
        """
        inverse = inverse_blocks(self._assembly.diagonal_blocks(matrix))
        finite = bool(np.isfinite(inverse).all())
        if not self._assembly.comm.allreduce(finite, op=MPI.LAND):
            raise SolverError(
                "a node has no stiffness in some direction, or one that is not finite; take a "
                "smaller step, and check the mesh and the materials"
            )
        if self._solver is None:
            self._inverse = _block_diagonal(matrix, inverse)
            self._solver = self._begin(matrix, PETSc.PC.Type.MAT)
        else:
            assert self._inverse is not None
            values, _ = block_values(self._inverse, (len(inverse), 0))
            values[:] = inverse.reshape(-1, 9)
            mark_changed(self._inverse)
        self._solver.setOperators(matrix, self._inverse)
        self._set_up()

    def close(self) -> None:
        """Free the solver; collective."""
        super().close()
        if self._inverse is not None:
            self._inverse.destroy()
            self._inverse = None


def _block_diagonal(like: PETSc.Mat, blocks: Array) -> PETSc.Mat:
    """Matrix of symmetric blocks (owned nodes, 3, 3) on the diagonal."""
    first, _ = like.getOwnershipRange()
    rows = np.arange(len(blocks) + 1, dtype=PETSc.IntType)
    csr = (rows, first // 3 + rows[:-1], blocks.ravel())
    return PETSc.Mat().createBAIJ(like.getSizes(), bsize=3, csr=csr, comm=like.getComm())


class MultigridGradients(_Gradients):
    """Conjugate gradients with PETSc's GAMG, kept between matrices while it serves.

    References: Vanek, Mandel and Brezina, Computing 56 (1996) 179-196 (smoothed aggregation for
        elasticity).

    Args:
        assembly: the body's, which knows its rigid motions.
        tolerance: see `linear_solver`.
        iterations: largest number of iterations of one solve.
    """

    def __init__(self, assembly: Assembly, *, tolerance: float, iterations: int) -> None:
        super().__init__(tolerance=tolerance, iterations=iterations)
        self._assembly = assembly
        self._plain: PETSc.Mat | None = None
        self._first = 0  # iterations of the first solve with the present hierarchy

    def prepare(self, matrix: PETSc.Mat) -> None:
        """Take a matrix; the caller keeps it alive and unchanged until the last solve with it.

        The diagonal of its held rows is made like that of the others: another misleads the
        smoothers.
        """
        self._assembly.level_held_rows(matrix)
        if self._solver is None or self.iterations > _STALE * self._first + 2:
            self._build(matrix)
        else:
            self._solver.setOperators(matrix, self._plain)
            self._set_up()

    def _build(self, matrix: PETSc.Mat) -> None:
        """Make a hierarchy from this very matrix."""
        self.close()
        if not np.isfinite(matrix.norm(PETSc.NormType.FROBENIUS)):
            raise SolverError(INFINITE)
        self._first = self.iterations = 0
        self._plain = self._preconditioned(matrix)
        self._solver = self._begin(matrix, PETSc.PC.Type.GAMG)
        self._solver.setOperators(matrix, self._plain)
        self._solver.getPC().setReusePreconditioner(True)
        self._set_up()

    def _preconditioned(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """A scalar copy for GAMG, with the rigid motions as its near kernel."""
        plain = matrix.convert("aij", PETSc.Mat())
        plain.setBlockSize(3)
        plain.setOption(PETSc.Mat.Option.SPD, True)
        vectors = []
        for column in orthonormal_columns(self._assembly.comm, self._assembly.rigid_motions()).T:
            vector = plain.createVecRight()
            vector.array[:] = column
            vectors.append(vector)
        kernel = PETSc.NullSpace().create(vectors=vectors, comm=matrix.getComm())
        plain.setNearNullSpace(kernel)
        for thing in (kernel, *vectors):
            thing.destroy()
        return plain

    def solve(self, right_side: Array) -> Array:
        """Solve for one right-hand side (owned dofs,), zero at held components."""
        assert self._solver is not None, "prepare a matrix first"
        try:
            solution = super().solve(right_side)
        except SolverError:
            if self._first == 0:
                raise
            # The hierarchy was made for another matrix: one of this matrix may still do.
            matrix, _ = self._solver.getOperators()
            self._build(matrix)
            solution = super().solve(right_side)
        self._first = self._first or self.iterations
        held = self._assembly.held[: self._assembly.owned].ravel()
        solution[held] = 0.0  # the smoothers leave traces in it
        return solution

    def close(self) -> None:
        """Free the solver; collective."""
        super().close()
        if self._plain is not None:
            self._plain.destroy()
            self._plain = None
