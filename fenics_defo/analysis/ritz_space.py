"""A growing space and the Ritz pairs of K x = θ M x in it, with few passes over its vectors.

What bounds a search of many steps is the memory that its vectors V are read from. Here a step reads
them twice: once for their products with K B and M B of a new block B, and once to combine both the
Ritz vectors and what is new of the block. All between is done with small matrices: with C = Vᵀ M B
and Z that orthonormalises Bᵀ M B - Cᵀ C, the new vectors are (B - V C) Z, and Vᵀ K V grows by
combinations of Vᵀ K B and Bᵀ K B. Nothing is multiplied twice, and K V is not kept.

The difference loses the digits that B has in common with V: where those are too many, B is
orthogonalised and multiplied once more. The inner product is that of M, whose round-off is small.
In that of K the corrections of Ritz vectors would be orthogonal to the space as they are, but on
thin bodies its round-off hides how they lie to the lowest modes.
"""

from collections.abc import Callable

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Squared lengths. A column whose part outside the basis is smaller, relative to the whole, is
# round-off.
_DEPENDENT = 1e-22
# Parts outside the basis, and outside other columns, that are computed with digits enough.
_ENOUGH, _APART = 1e-2, 1e-5


class RitzSpace:
    """M-orthonormal vectors V with Vᵀ K V.

    Args:
        multiply: X -> K X and M X side by side (owned dofs, 2 b).
        comm: communicator of the rows.
        rows: owned dofs.
        columns: the most vectors there will be, a block included.
    """

    def __init__(
        self, multiply: Callable[[Array], Array], comm: MPI.Comm, rows: int, columns: int
    ) -> None:
        self._vectors = np.empty((rows, columns), order="F")
        self._multiply = multiply
        self._comm = comm
        self._projected = np.zeros((0, 0))
        # Of the last block: behind so many finished vectors, and what makes vectors of both.
        self._finished = 0
        self._correction = np.zeros((0, 0))

    @property
    def size(self) -> int:
        """Number of vectors."""
        return len(self._projected)

    @property
    def grew(self) -> bool:
        """Whether the last block brought anything new."""
        return self._correction.shape[1] > 0

    def ritz(self) -> tuple[Array, Array]:
        """Ritz values θ (size,), ascending, and their vectors' coefficients (size, size)."""
        values, inner = np.linalg.eigh(self._projected)
        return values, inner

    def combine(self, coefficients: Array) -> Array:
        """V times coefficients (size, k): (owned dofs, k) in Fortran order."""
        old, correction = self._finished, self._correction
        if old == self.size:
            return combined(self._vectors[:, :old], coefficients)
        lifted = correction @ coefficients[old:]
        lifted[:old] += coefficients[:old]
        both = np.hstack([correction, lifted])
        result = combined(self._vectors[:, : len(both)], both)
        self._vectors[:, old : self.size] = result[:, : self.size - old]
        self._finished = self.size
        return result[:, self.size - old :]

    def extend(self, block: Array) -> None:
        """Add what is new of a block (owned dofs, b); collective."""
        old = self._finished
        assert old == self.size, "the block before has not been combined"
        stiffness, mass = self._products(block)
        whole = np.diag(mass[old:])
        for _ in range(2):
            along = mass[:old]
            outside = np.diag(mass[old:]) - np.einsum("ij,ij->j", along, along)
            if (outside >= _ENOUGH * np.diag(mass[old:])).all():
                break
            stiffness, mass = self._products(block - combined(self._vectors[:, :old], along))
        correction, sure = _orthonormalising(mass, old, whole)
        if not sure:
            fresh = combined(self._vectors[:, : len(correction)], correction)
            stiffness, mass = self._products(fresh)
            correction, _ = _orthonormalising(mass, old, np.zeros(fresh.shape[1]))
        self._correction = correction
        self._projected = _grown(self._projected, stiffness, correction)

    def _products(self, block: Array) -> tuple[Array, Array]:
        """Products (size + b, b) of vectors and block with K and M times the block; collective."""
        end = self.size + block.shape[1]
        self._vectors[:, self.size : end] = block
        both = self.sum(self._vectors[:, :end].T @ self._multiply(block))
        return both[:, : block.shape[1]], both[:, block.shape[1] :]

    def restart(self, values: Array, inner: Array) -> None:
        """Replace the basis by some of its Ritz vectors."""
        self._vectors[:, : len(values)] = self.combine(inner)
        self._projected = np.diag(values)
        self._finished = len(values)

    def sum(self, local: Array) -> Array:
        """Sum over the ranks; collective."""
        local = np.ascontiguousarray(local)
        self._comm.Allreduce(MPI.IN_PLACE, local, op=MPI.SUM)
        return local


def combined(columns: Array, coefficients: Array) -> Array:
    """``columns @ coefficients`` in Fortran order, twice as fast as NumPy's own order of it."""
    return (coefficients.T @ columns.T).T


def _orthonormalising(mass: Array, old: int, whole: Array) -> tuple[Array, bool]:
    """What makes orthonormal vectors of a basis and a block, and whether to digits enough.

    Args:
        mass: (old + b, b) products of basis and block with M times the block.
        old: size of the basis.
        whole: (b,) squared lengths that round-off relates to.

    Returns:
        (old + b, k) coefficients.
    """
    along, own = mass[:old], mass[old:]
    outside = own - along.T @ along
    left = np.diag(outside)
    new = left > np.maximum(_DEPENDENT * whole, 0.0)
    scale = np.sqrt(left[new])
    values, vectors = np.linalg.eigh(outside[np.ix_(new, new)] / np.outer(scale, scale))
    kept = values > 1e-14 * len(values)
    turn = np.zeros((len(own), int(kept.sum())))
    turn[new] = vectors[:, kept] / scale[:, None] / np.sqrt(values[kept])
    return np.vstack([-along @ turn, turn]), bool((values > _APART).all())


def _grown(projected: Array, products: Array, correction: Array) -> Array:
    """Vᵀ K V with the new vectors, from the products of vectors and block with K times it."""
    old = len(projected)
    every = np.block([[projected, products[:old]], [products[:old].T, products[old:]]])
    new = every @ correction
    own = correction.T @ new
    return np.block([[projected, new[:old]], [new[:old].T, 0.5 * (own + own.T)]])
