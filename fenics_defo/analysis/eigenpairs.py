"""The matrices of an eigenvalue problem, pairs of it, and what is computed with both."""

from contextlib import closing
from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from fenics_defo.analysis.ritz_space import combined
from fenics_defo.fem.linalg import Factorization
from fenics_defo.fem.mass import ConsistentMass
from fenics_defo.fem.pencil import Pencil

Array = NDArray[np.float64]


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
            combined(self.vectors, rotation),
            combined(self.forces, rotation),
            combined(self.momenta, rotation),
            self.converged,
        )


@dataclass
class EigenProblem:
    """K x = λ M x with K symmetric and M positive semidefinite.

    Args:
        stiffness: K [N/m], held rows with a positive diagonal.
        mass: M.
        pencil: products with both.
        shift: σ [rad²/s²], at or below the wanted λ.
        definite: whether K - σ M is known to be positive definite.
        independent: number of components that are not held.
        free: (owned dofs,) bool, components that are not held.
    """

    stiffness: PETSc.Mat
    mass: ConsistentMass
    pencil: Pencil
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
            mass = self.mass.matrix()
            matrix.axpy(-shift, mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
            mass.destroy()
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return matrix

    def random_block(self, rng: np.random.Generator, width: int) -> Array:
        """Random vectors that are zero at held components."""
        block = np.asfortranarray(rng.standard_normal((len(self.free), width)))
        block[~self.free] = 0.0
        return block

    def below(self, value: float) -> int:
        """Number of eigenvalues below a value, by the inertia of K - value M."""
        matrix = self.shifted(value)
        try:
            with closing(Factorization(matrix, definite=False)) as factors:
                return factors.negative_pivots
        finally:
            matrix.destroy()

    def ritz(self, vectors: Array, *, converged: int) -> Pairs:
        """Best pairs in the space of some vectors that are nearly orthonormal in M; collective."""
        vectors = np.asfortranarray(vectors)
        both, count = self.pencil.multiply(vectors), vectors.shape[1]
        stiffness, mass = np.hsplit(self.products(vectors, both), 2)
        values, turn = scipy.linalg.eigh(stiffness, mass)
        forces, momenta = (combined(part, turn) for part in (both[:, :count], both[:, count:]))
        return Pairs(values, combined(vectors, turn), forces, momenta, converged)

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
