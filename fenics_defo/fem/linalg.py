"""Direct and blocked linear algebra on PETSc matrices, with NumPy arrays in and out."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SolverError
from fenics_defo.fem.compat import dolfinx  # noqa: F401  (PETSc's wheel wants DOLFINx's order of loading)

Array = NDArray[np.float64]
Precision = Literal["single", "double"]

#: Prefix of PETSc's options for the factorisation: ``-fenics_defo_mat_mumps_icntl_7 4`` in
#: ``PETSC_OPTIONS`` orders by PORD instead of METIS.
OPTIONS_PREFIX = "fenics_defo_"

# MUMPS's control parameters, by their number in its users' guide.
_ORDERING, _METIS = 7, 5
_MORE_MEMORY = 14
_NULL_PIVOTS = 24
_STATUS, _STATUS_DETAIL, _NEGATIVE_PIVOTS = 1, 2, 12
_OUT_OF_MEMORY = (-9, -13)


class Factorization:
    """MUMPS's factors of a symmetric matrix; collective, and so is closing it.

    Args:
        matrix: assembled symmetric matrix; not kept.
        definite: promise that it is positive definite, which spares the search for pivots. Without
            the promise a matrix with pivots of both signs is factorised accurately.
        precision: of the factors. Those in "single" are half as large, cost half the time and solve
            to a few digits only; where PETSc or MUMPS has none, they are in double precision.

    Raises:
        SolverError: the matrix is singular, or memory ran out.
    """

    def __init__(
        self, matrix: PETSc.Mat, *, definite: bool, precision: Precision = "double"
    ) -> None:
        # Half a symmetric matrix in 3x3 blocks: what MUMPS wants, without a search for the
        # triangle.
        self._matrix = matrix.convert("sbaij", PETSc.Mat())
        self._matrix.setOption(PETSc.Mat.Option.SPD, definite)
        self._solver = PETSc.PC().create(matrix.getComm())
        self._solver.setOptionsPrefix(OPTIONS_PREFIX)
        self._solver.setOperators(self._matrix)
        self._solver.setType(PETSc.PC.Type.CHOLESKY)
        self._solver.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        self._solver.setFactorSetUpSolverType()
        factor = self._solver.getFactorMatrix()
        factor.setMumpsIcntl(_ORDERING, _METIS)
        factor.setMumpsIcntl(_MORE_MEMORY, 50)
        factor.setMumpsIcntl(_NULL_PIVOTS, 0 if definite else 1)
        factor.setOptionsPrefix(OPTIONS_PREFIX)
        self._definite = definite
        with _option("pc_precision", precision):
            factor.setFromOptions()
            self._factorise()

    def refactorise(self, matrix: PETSc.Mat) -> None:
        """Take another matrix with the same entries; the order of elimination is kept; collective.

        Raises:
            SolverError: the matrix is singular, or memory ran out; then this object is closed.
        """
        matrix.convert("sbaij", self._matrix)
        self._matrix.setOption(PETSc.Mat.Option.SPD, self._definite)
        self._solver.setOperators(self._matrix)
        self._factorise()

    def _factorise(self) -> None:
        try:
            self._solver.setUp()
        except PETSc.Error as error:
            self.close()
            raise SolverError(f"MUMPS could not factorise the stiffness ({error})") from error
        self._factor = self._solver.getFactorMatrix()
        status = self._factor.getMumpsInfog(_STATUS)
        if status < 0:
            detail = self._factor.getMumpsInfog(_STATUS_DETAIL)
            size = self._matrix.size[0]
            self.close()
            raise SolverError(_failure(status, detail, size))

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the matrix (Sylvester's law of inertia)."""
        return int(self._factor.getMumpsInfog(_NEGATIVE_PIVOTS))

    def solve(self, right_sides: Array) -> Array:
        """Solve for a block of right-hand sides at once.

        Args:
            right_sides: (owned dofs, b) in Fortran order.

        Returns:
            (owned dofs, b) in Fortran order.
        """
        solution = np.empty_like(right_sides, order="F")
        given = _dense(self._matrix, right_sides)
        found = _dense(self._matrix, solution)
        try:
            self._factor.matSolve(given, found)
        except PETSc.Error as error:
            raise SolverError(f"MUMPS could not solve with its factors ({error})") from error
        finally:
            given.destroy()
            found.destroy()
        return solution

    def close(self) -> None:
        """Free the factors; collective."""
        self._solver.destroy()
        self._matrix.destroy()


@contextmanager
def _option(name: str, value: str) -> Iterator[None]:
    """One of PETSc's options, unless the user has set it."""
    options = PETSc.Options(OPTIONS_PREFIX)
    if options.hasName(name):
        yield
        return
    options.setValue(name, value)
    try:
        yield
    finally:
        options.delValue(name)


def multiply(matrix: PETSc.Mat, block: Array) -> Array:
    """Matrix times a block of vectors; collective.

    Args:
        matrix: square matrix, not one that holds its upper half only.
        block: (owned dofs, b) in Fortran order.

    Returns:
        (owned dofs, b) in Fortran order.
    """
    given = _dense(matrix, np.asfortranarray(block))
    product = matrix.matMult(given)
    result = np.array(product.getDenseArray(), order="F")
    given.destroy()
    product.destroy()
    return result


def combine(
    target: PETSc.Mat, stiffness: PETSc.Mat, scale: float, mass: PETSc.Mat, mass_scale: float
) -> None:
    """Overwrite ``target`` with ``scale`` K + ``mass_scale`` M; nothing is allocated; collective.

    Args:
        target: assembled matrix with the entries of the others; may be K itself.
        stiffness: K.
        scale: its factor.
        mass: M, with the same entries.
        mass_scale: its factor.
    """
    if target.handle != stiffness.handle:
        stiffness.copy(target, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    if scale != 1.0:
        target.scale(scale)
    target.axpy(mass_scale, mass, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)


def orthonormal_columns(comm: MPI.Comm, block: Array) -> Array:
    """Orthonormal basis (owned dofs, k) of the space of the columns (owned dofs, b); collective."""
    lengths = np.sqrt(comm.allreduce(np.einsum("ij,ij->j", block, block)))
    unit = block / np.where(lengths > 0.0, lengths, 1.0)
    values, vectors = np.linalg.eigh(comm.allreduce(unit.T @ unit))
    kept = values > 1e-10
    return unit @ (vectors[:, kept] / np.sqrt(values[kept]))


def _dense(like: PETSc.Mat, block: Array) -> PETSc.Mat:
    (rows, _), (total, _) = like.getLocalSize(), like.getSize()
    matrix = PETSc.Mat().createDense(
        ((rows, total), (None, block.shape[1])), array=block, comm=like.getComm()
    )
    matrix.assemble()
    return matrix


def _failure(status: int, detail: int, size: int) -> str:
    if status in _OUT_OF_MEMORY:
        return (
            f"memory ran out while factorising {size} degrees of freedom (MUMPS {status}, "
            f"{detail}); use a coarser mesh, order 1, or the iterative solver (--solver iterative)"
        )
    if status == -10:
        return (
            f"the stiffness of {size} degrees of freedom is singular (MUMPS -10, {detail}): a part "
            "of the body can move without resistance; hold it, or check the mesh for parts that "
            "share no nodes"
        )
    return f"MUMPS could not factorise {size} degrees of freedom (error {status}, {detail})"
