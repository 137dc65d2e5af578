"""Conjugate gradients with algebraic multigrid: a solver whose memory grows with the mesh only."""

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SolverError
from fenics_defo.fem.linalg import OPTIONS_PREFIX

Array = NDArray[np.float64]

_INDEFINITE = (
    PETSc.KSP.ConvergedReason.DIVERGED_INDEFINITE_MAT,
    PETSc.KSP.ConvergedReason.DIVERGED_INDEFINITE_PC,
)


class MultigridSolver:
    """CG with PETSc's GAMG, which knows the rigid motions; collective.

    References: Vanek, Mandel and Brezina, Computing 56 (1996) 179-196 (smoothed aggregation for
        elasticity).

    Args:
        matrix: positive definite matrix in 3x3 blocks; not kept.
        near_kernel: (owned dofs, 6) rigid motions, zero at held components.
        free: (owned dofs,) bool, components that are not held.
        rtol: relative residual at which the iteration stops.
        iterations: largest number of iterations for one right-hand side.
    """

    def __init__(
        self,
        matrix: PETSc.Mat,
        near_kernel: Array,
        free: NDArray[np.bool_],
        *,
        rtol: float,
        iterations: int = 1000,
    ) -> None:
        self._matrix = matrix.convert("aij", PETSc.Mat())
        self._matrix.setBlockSize(3)
        self._free = free
        self._scale_held_rows()
        self._matrix.setOption(PETSc.Mat.Option.SPD, True)
        vectors = _orthonormal([self._vector(column) for column in near_kernel.T])
        kernel = PETSc.NullSpace().create(vectors=vectors, comm=matrix.getComm())
        self._matrix.setNearNullSpace(kernel)
        kernel.destroy()
        for vector in vectors:
            vector.destroy()
        self._solver = PETSc.KSP().create(matrix.getComm())
        self._solver.setOptionsPrefix(OPTIONS_PREFIX)
        self._solver.setOperators(self._matrix)
        self._solver.setType(PETSc.KSP.Type.CG)
        self._solver.getPC().setType(PETSc.PC.Type.GAMG)
        self._solver.setTolerances(rtol=rtol, atol=0.0, max_it=iterations)
        self._solver.setFromOptions()
        self._solver.setUp()
        self.iterations = 0

    def solve(self, right_sides: Array) -> Array:
        """Solve for a block of right-hand sides (owned dofs, b), zero at held components.

        Raises:
            SolverError: the iteration did not converge.
        """
        solution = np.empty_like(right_sides, order="F")
        b, x = self._matrix.createVecLeft(), self._matrix.createVecRight()
        for column in range(right_sides.shape[1]):
            b.array[:] = right_sides[:, column]
            self._solver.solve(b, x)
            self.iterations += self._solver.getIterationNumber()
            self._check_converged()
            solution[:, column] = x.array
        b.destroy()
        x.destroy()
        solution[~self._free] = 0.0  # the smoothers leave traces in it
        return solution

    def _check_converged(self) -> None:
        reason, steps = self._solver.getConvergedReason(), self._solver.getIterationNumber()
        if reason in _INDEFINITE:
            raise SolverError(
                "conjugate gradients met a matrix that is not positive definite: the given "
                "displacement is not a stable state, or a part of the body hardly hangs on; "
                "the direct solver tells more (--solver davidson, solver='davidson')"
            )
        if reason <= 0:
            raise SolverError(
                f"conjugate gradients did not converge in {steps} iterations; use the direct "
                "solver (--solver davidson, solver='davidson'), or improve the mesh's slivers"
            )

    def _scale_held_rows(self) -> None:
        """Give held rows the size of the others: a tiny diagonal misleads the smoothers."""
        diagonal = self._matrix.getDiagonal()
        values = diagonal.array.copy()
        total = self._matrix.getComm().tompi4py().allreduce(values[self._free].sum())
        count = self._matrix.getComm().tompi4py().allreduce(int(self._free.sum()))
        values[~self._free] = total / count
        diagonal.array[:] = values
        self._matrix.setDiagonal(diagonal)
        diagonal.destroy()

    def _vector(self, values: Array) -> PETSc.Vec:
        vector = self._matrix.createVecRight()
        vector.array[:] = values
        return vector

    def close(self) -> None:
        """Free the solver; collective."""
        self._solver.destroy()
        self._matrix.destroy()


def _orthonormal(vectors: list[PETSc.Vec]) -> list[PETSc.Vec]:
    """Orthonormalise in place; those that depend on the others are destroyed and left out."""
    kept: list[PETSc.Vec] = []
    for vector in vectors:
        before = vector.norm()
        for _ in range(2):
            for other in kept:
                vector.axpy(-vector.dot(other), other)
        length = vector.norm()
        if before > 0.0 and length > 1e-8 * before:
            vector.scale(1.0 / length)
            kept.append(vector)
        else:
            vector.destroy()
    return kept
