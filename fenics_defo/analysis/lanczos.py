"""Block Lanczos iteration with thick restarts for the eigenpairs of K x = λ M x next to a shift.

The operator is (K - σ M)⁻¹ M, self-adjoint in the inner product of M; its largest eigenvalues θ =
1/(λ - σ) belong to the λ next to σ. Solving for a block of vectors reads MUMPS's factors once for
all of them, where one vector at a time is bound by memory: this is why blocks win over SLEPc's
Krylov-Schur, which is one vector at a time.

References: Grimes, Lewis and Simon, SIAM J. Matrix Anal. Appl. 15 (1994) 228-272 (shifted block
Lanczos); Wu and Simon, SIAM J. Matrix Anal. Appl. 22 (2000) 602-616 (thick restart); Stewart,
Matrix Algorithms II, SIAM 2001, chapter 5.
"""

from collections.abc import Callable
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]
BlockMap = Callable[[Array], Array]

#: Vectors solved for at once: more of them read the factors less often, and are more in all.
BLOCK = 4

# A column whose part outside the basis is smaller, relative to the whole, is round-off.
_DEPENDENT = 1e-11
_GUARD_TOLERANCE = 1e-3


@dataclass(frozen=True, slots=True)
class RitzPairs:
    """Converged pairs of the shifted and inverted problem.

    Args:
        theta: (k,) eigenvalues 1/(λ - σ), largest first.
        vectors: (owned dofs, k) in Fortran order, orthonormal in M.
        converged: how many of them, from the first, are within the tolerance; the rest are guards.
        solves: number of vectors that were solved for.
    """

    theta: Array
    vectors: Array
    converged: int
    solves: int


def block_lanczos(
    solve: BlockMap,
    mass: BlockMap,
    random: Callable[[], Array],
    count: int,
    *,
    comm: MPI.Comm,
    independent: int,
    guard: int = 0,
    tolerance: float = 1e-9,
    basis_limit: int | None = None,
    max_restarts: int = 40,
) -> RitzPairs:
    """Largest eigenvalues of the operator solve(mass(x)), all positive. Collective.

    Args:
        solve: X -> (K - σ M)⁻¹ X for a block (owned dofs, b), K - σ M positive definite on what is
            wanted.
        mass: X -> M X.
        random: gives a random block (owned dofs, b) in Fortran order; b is the block size.
        count: number of pairs.
        comm: communicator of the rows.
        independent: dimension of the space, that is the number of components that are not held.
        guard: number of further pairs, to 1e-3 only: their θ, whose error is the square of that,
            show what comes next.
        tolerance: largest error bound of an accepted θ, relative to it.
        basis_limit: vectors kept before a restart; ``max(4 count, count + 15 b)`` if not given.
        max_restarts: number of restarts before giving up.

    Returns:
        at least ``count + guard`` pairs, as far as the space holds so many.

    Raises:
        EigenSolveError: fewer than ``count`` pairs converged.
    """
    start = random()
    width = start.shape[1]
    limit = basis_limit or max(4 * count, count + guard + 15 * width)
    basis = _Basis(len(start), limit + width, mass, comm)
    basis.append(solve(mass(start)))
    projected = np.zeros((0, 0))
    solves, restarts = width, 0
    while True:
        fresh = basis.newest
        image = solve(basis.mass_columns(fresh))
        solves += image.shape[1]
        coefficients, rest = basis.append(image)
        projected = _grow(projected, coefficients, fresh)
        theta, inner = np.linalg.eigh(projected)
        theta, inner = theta[::-1], inner[:, ::-1]
        bounds = np.linalg.norm(rest @ inner[fresh], axis=0)
        whole = len(projected) == independent  # then the pairs are exact but for round-off
        done = independent if whole else _leading(bounds <= tolerance * np.abs(theta))
        shown = _leading(bounds <= _GUARD_TOLERANCE * np.abs(theta))
        if (done >= count and shown >= count + guard) or whole:
            break
        if rest.shape[0] == 0:  # an invariant subspace, without all of a multiple eigenvalue
            basis.append(solve(mass(random())))
            solves += width
        if len(projected) + basis.newest_width > limit:
            if restarts == max_restarts:
                raise EigenSolveError(
                    f"{done} of {count} modes converged after {restarts} restarts; "
                    "ask for fewer modes, or loosen the tolerance"
                )
            restarts += 1
            keep = min(len(theta) - width, count + guard + width)
            basis.restart(inner[:, :keep])
            # What couples the kept pairs to the newest block is found anew by projection.
            projected = np.diag(theta[:keep])
    if done < count:
        raise EigenSolveError(
            f"the body has only {len(projected)} independent motions, "
            f"and {count} modes were asked for"
        )
    kept = slice(0, max(done, min(shown, count + guard)))
    return RitzPairs(theta[kept], basis.combine(inner[:, kept]), done, solves)


def _leading(accepted: NDArray[np.bool_]) -> int:
    return len(accepted) if accepted.all() else int(np.argmin(accepted))


def _grow(projected: Array, coefficients: Array, fresh: slice) -> Array:
    """Add the newest columns of the projected operator Vᵀ M A V, symmetric by construction."""
    size = coefficients.shape[0]
    grown = np.zeros((size, size))
    grown[: len(projected), : len(projected)] = projected
    grown[:, fresh] = coefficients
    grown[fresh, :] = coefficients.T
    grown[fresh, fresh] = 0.5 * (coefficients[fresh] + coefficients[fresh].T)
    return grown


class _Basis:
    """M-orthonormal vectors V with their products M V; the last block awaits its image."""

    def __init__(self, rows: int, columns: int, mass: BlockMap, comm: MPI.Comm) -> None:
        self._vectors = np.empty((rows, columns), order="F")
        self._products = np.empty((rows, columns), order="F")
        self._mass = mass
        self._comm = comm
        self._size = 0
        self._recent = 0
        self.newest = slice(0, 0)

    @property
    def newest_width(self) -> int:
        return self.newest.stop - self.newest.start

    def mass_columns(self, columns: slice) -> Array:
        return self._products[:, columns]

    def combine(self, coefficients: Array) -> Array:
        return np.asfortranarray(self._vectors[:, : len(coefficients)] @ coefficients)

    def append(self, block: Array) -> tuple[Array, Array]:
        """Orthonormalise a block against the basis and itself, and add what is new of it.

        Returns:
            ``coefficients`` (size before, b) and ``rest`` (new columns, b): block = V coefficients
            + V_new rest.
        """
        size = self._size
        before = self._norms(block)
        coefficients = np.zeros((size, block.shape[1]))
        # The image of the newest block has its large parts along the last two blocks, unless a
        # restart has just made one of all; a second pass over everything clears the round-off.
        for first in (self._recent, 0):
            step = self._sum(self._products[:, first:size].T @ block)
            block = block - self._vectors[:, first:size] @ step
            coefficients[first:] += step
        new = self._norms(block) > _DEPENDENT * before
        fresh, product, rest = self._orthonormal(np.asfortranarray(block[:, new]))
        end = size + fresh.shape[1]
        self._vectors[:, size:end] = fresh
        self._products[:, size:end] = product
        self._recent = self.newest.start
        self.newest = slice(size, end)
        self._size = end
        full = np.zeros((fresh.shape[1], block.shape[1]))
        full[:, new] = rest
        return coefficients, full

    def _orthonormal(self, block: Array) -> tuple[Array, Array, Array]:
        """Q, M Q and R with block = Q R and Q orthonormal in M; dependent columns go."""
        product = self._mass(block)
        total = np.eye(block.shape[1])
        for _ in range(2):
            gram = self._sum(block.T @ product)
            scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
            values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
            keep = values > 1e-14 * len(values)
            root = np.sqrt(values[keep])
            turn = vectors[:, keep] / scale[:, None] / root
            block, product = np.asfortranarray(block @ turn), np.asfortranarray(product @ turn)
            total = (root[:, None] * vectors[:, keep].T * scale) @ total
        return block, product, total

    def _norms(self, block: Array) -> Array:
        return np.sqrt(self._sum(np.einsum("ij,ij->j", block, block)))

    def restart(self, coefficients: Array) -> None:
        """Replace all but the newest block by combinations of the older ones."""
        size, keep = coefficients.shape
        width = self.newest_width
        for table in (self._vectors, self._products):
            table[:, :keep] = table[:, :size] @ coefficients
            table[:, keep : keep + width] = table[:, size : size + width].copy()
        self.newest = slice(keep, keep + width)
        self._recent = 0
        self._size = keep + width

    def _sum(self, local: Array) -> Array:
        local = np.ascontiguousarray(local)
        self._comm.Allreduce(MPI.IN_PLACE, local, op=MPI.SUM)
        return local
