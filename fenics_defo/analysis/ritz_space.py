"""A growing space and the Ritz pairs of A x = θ M x in it, with few passes over its vectors.

What bounds a search of many steps is the memory that its vectors are read from. Here a step reads
them twice: once for their products with A and M times the new block, once to combine Ritz vectors.
The basis is roughly orthonormal in A: a correction T (A x - θ M x) of a Ritz vector is orthogonal
to it as it is, as nearly as T is A⁻¹, since the residual is orthogonal to the space (Galerkin). So
the corrections enter it without having been orthogonalised, and the projected problem takes the
Gram matrix Vᵀ A V as it is. Only a block that leans on the basis, as a random one does, or whose
columns nearly depend on each other, is orthogonalised first.
"""

from collections.abc import Callable

from mpi4py import MPI

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]

# Shares of a block's columns outside the basis and each other, by their squared norm: below the
# first they are round-off, below the second digits are lost unless it is orthogonalised.
_DEPENDENT = 1e-14
_NEARLY = 1e-6
# Squared length, in the basis, of a direction whose part outside it is 1.
_LEANING = 1.0
_ROUNDS = 3


class RitzSpace:
    """Vectors V with G = Vᵀ A V and Vᵀ M V.

    Args:
        multiply: X -> A X and M X side by side (owned dofs, 2 b).
        comm: communicator of the rows.
        rows: owned dofs.
        columns: the most vectors there will be.
    """

    def __init__(
        self, multiply: Callable[[Array], Array], comm: MPI.Comm, rows: int, columns: int
    ) -> None:
        self._vectors = np.empty((rows, columns), order="F")
        self._multiply = multiply
        self._comm = comm
        self._gram = self._mass = np.zeros((0, 0))
        self.size = 0
        #: whether the last block brought anything new
        self.grew = False

    def ritz(self) -> tuple[Array, Array]:
        """Ritz values θ (size,), ascending, and the vectors' coefficients (size, size).

        Raises:
            EigenSolveError: A is not positive definite.
        """
        try:
            inverses, inner = scipy.linalg.eigh(self._mass, self._gram, check_finite=False)
        except np.linalg.LinAlgError as error:
            raise EigenSolveError("the stiffness is not positive definite") from error
        inverses = np.maximum(inverses[::-1], np.finfo(float).tiny)
        return 1.0 / inverses, inner[:, ::-1] / np.sqrt(inverses)

    def combine(self, coefficients: Array) -> Array:
        """V times coefficients (size, k): (owned dofs, k) in Fortran order."""
        return combined(self._vectors[:, : self.size], coefficients)

    def extend(self, block: Array) -> None:
        """Add what is new of a block (owned dofs, b); collective."""
        size = self.size
        for _ in range(_ROUNDS):
            gram, mass = self._products(block)
            turn, shadow, sound = self._directions(gram[:size], gram[size:])
            if sound or not turn.shape[1]:
                break
            correction = np.vstack([-shadow @ turn, turn])
            block = combined(self._vectors[:, : size + block.shape[1]], correction)
        self.size = size + turn.shape[1]
        self.grew = self.size > size
        self._vectors[:, size : self.size] = combined(block, turn)
        self._gram = _bordered(self._gram, gram, turn)
        self._mass = _bordered(self._mass, mass, turn)

    def _products(self, block: Array) -> tuple[Array, Array]:
        """Products (size + b, b) of the basis and the block with A and M times the block."""
        end = self.size + block.shape[1]
        self._vectors[:, self.size : end] = block
        both = self.sum(self._vectors[:, :end].T @ self._multiply(block))
        return both[:, : block.shape[1]], both[:, block.shape[1] :]

    def _directions(self, along: Array, gram: Array) -> tuple[Array, Array, bool]:
        """Combinations (b, k) of a block's columns that are orthonormal outside the basis.

        Args:
            along: (size, b) products of the basis with A times the block.
            gram: (b, b) those of the block.

        Returns:
            them; coefficients (size, b) of the block's part in the basis; and whether the
            combinations, that part included, are fit for the basis.
        """
        shadow = scipy.linalg.solve(self._gram, along, assume_a="pos") if self.size else along
        inside = along.T @ shadow
        scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh((gram - inside) / np.outer(scale, scale))
        kept = values > _DEPENDENT * len(values)
        turn = vectors[:, kept] / scale[:, None] / np.sqrt(values[kept])
        leaning = np.einsum("ij,ik,kj->j", turn, inside, turn)
        return turn, shadow, bool((values > _NEARLY).all() and (leaning <= _LEANING).all())

    def restart(self, values: Array, inner: Array) -> None:
        """Replace the basis by some of its Ritz vectors."""
        self.size = len(values)
        self._vectors[:, : self.size] = combined(
            self._vectors[:, : len(inner)], inner / np.sqrt(values)
        )
        self._gram, self._mass = np.eye(self.size), np.diag(1.0 / values)

    def sum(self, local: Array) -> Array:
        """Sum over the ranks; collective."""
        local = np.ascontiguousarray(local)
        self._comm.Allreduce(MPI.IN_PLACE, local, op=MPI.SUM)
        return local


def combined(columns: Array, coefficients: Array) -> Array:
    """``columns @ coefficients`` in Fortran order, twice as fast as NumPy's own order of it."""
    return (coefficients.T @ columns.T).T


def _bordered(old: Array, products: Array, turn: Array) -> Array:
    """A symmetric matrix with rows and columns for a block's combinations."""
    size = len(old)
    along, own = products[:size] @ turn, turn.T @ products[size:] @ turn
    return np.block([[old, along], [along.T, 0.5 * (own + own.T)]])
