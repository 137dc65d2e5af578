"""Block Davidson iteration with thick restarts for the lowest eigenpairs of K x = λ M x.

The space grows by what a preconditioner makes of the residuals, T (K x - θ M x), and the pairs are
Ritz pairs of K and M themselves. With T = (K - σ M)⁻¹ this spans what shifted and inverted block
Lanczos spans, step by step; but T may be a rough inverse, since its errors are corrected by the
next residuals: factors in single precision, half as large and as dear as those in double
precision, or a few cycles of multigrid. With such a T the corrections also tell the error of x, as
T (K x - θ M x) = x - θ T M x is what another inverse iteration would change. Solving for a block of
vectors reads the factors once for all of them, which is what such a solve costs.

References: Davidson, J. Comput. Phys. 17 (1975) 87-94; Crouzeix, Philippe and Sadkane, SIAM J. Sci.
Comput. 15 (1994) 62-76 (block Davidson); Grimes, Lewis and Simon, SIAM J. Matrix Anal. Appl. 15
(1994) 228-272 (shifted block Lanczos).
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
BLOCK = 8

# A column whose part outside the basis is smaller, relative to the whole, is round-off.
_DEPENDENT = 1e-11
# Orthogonalising once loses the digits that a column loses in length; then it is done again.
_SHRUNK = 1e-3
_GUARD_TOLERANCE = 1e-3
# Multiple of the tolerance at which errors may stagnate: the stiffness of long thin bodies is so
# ill-conditioned that no more can be had. The residuals of the pairs are judged by the caller.
_ROUND_OFF_AT_MOST = 1e5
# A step that moves θ by less, relative to it, moves x by less than the square root of it.
_STILL, _GUARD_STILL = 1e-13, 1e-6


class RoughPreconditionerError(EigenSolveError):
    """A preconditioner does not resemble an inverse of the stiffness."""


@dataclass(frozen=True, slots=True)
class RitzVectors:
    """Lowest eigenvectors, and how far to trust them.

    Args:
        vectors: (owned dofs, k) in Fortran order, nearly orthonormal in M, lowest first.
        converged: how many of them, from the first, are within the tolerance; the rest are guards.
        solves: number of vectors that were preconditioned.
    """

    vectors: Array
    converged: int
    solves: int


def block_davidson(
    precondition: BlockMap,
    stiffness: BlockMap,
    mass: BlockMap,
    random: Callable[[], Array],
    count: int,
    *,
    comm: MPI.Comm,
    independent: int,
    guard: int = 0,
    tolerance: float = 1e-7,
    roughest: float = np.inf,
    basis_limit: int | None = None,
    max_restarts: int = 40,
) -> RitzVectors:
    """Lowest eigenvectors of K x = λ M x. Collective.

    Args:
        precondition: X -> T X for a block (owned dofs, b), roughly (K - σ M)⁻¹ X, in the space that
            is searched.
        stiffness: X -> K X.
        mass: X -> M X.
        random: gives a random block (owned dofs, b) in Fortran order; b is the block size.
        count: number of pairs.
        comm: communicator of the rows.
        independent: dimension of the space that is searched.
        guard: number of further pairs, to 1e-3 only: their λ, whose error is the square of that,
            show what comes next.
        tolerance: largest change of an accepted vector in another inverse iteration, in the norm
            of M.
        roughest: largest relative error of the preconditioner, (T b)ᵀ K (T b) against bᵀ T b for
            random b, that is tolerated.
        basis_limit: vectors kept before a restart; ``count + guard + max(count, 15 b)``
            if not given.
        max_restarts: number of restarts before giving up.

    Returns:
        ``count + guard`` vectors, as far as the space holds so many.

    Raises:
        RoughPreconditionerError: it is rougher than was tolerated.
        EigenSolveError: fewer than ``count`` converged.
    """
    start = random()
    width = start.shape[1]
    sought = min(count + guard, independent)
    limit = basis_limit or count + guard + max(count, 15 * width)
    space = _Space(len(start), limit + sought + width, stiffness, mass, comm)
    tolerances = np.where(np.arange(sought) < count, tolerance, _GUARD_TOLERANCE)
    solves, restarts, before, best = width, 0, np.zeros(0), np.inf
    load = mass(start)
    block = precondition(load)
    coordinates = space.extend(block)
    stiff = np.einsum("ij,ik,kj->j", coordinates, space.projected, coordinates)
    error = np.abs(stiff / space.sum(np.einsum("ij,ij->j", load, block)) - 1.0).max()
    if not error <= roughest:
        raise RoughPreconditionerError(f"the preconditioner errs by {error:.1e}")
    while True:
        values, inner = np.linalg.eigh(space.projected)
        if space.size == independent:  # then the pairs are exact but for round-off
            if independent < count:
                raise EigenSolveError(
                    f"the body has only {independent} independent motions, "
                    f"and {count} modes were asked for"
                )
            return RitzVectors(space.combine(inner), independent, solves)
        moving = _moving(values[:sought], before[:sought], count, float(values[-1]))
        before = values
        testing = space.size >= sought and not moving.size
        chosen = np.arange(sought) if testing else moving[:width]
        vectors, block = space.residuals(values[chosen], inner[:, chosen])
        block = precondition(block)
        solves += len(chosen)
        if testing:
            errors = np.sqrt(space.sum(np.einsum("ij,ij->j", block, mass(block))))
            worst = float((errors / tolerances).max())
            # Round-off of K x is all that is left where another step no longer helps.
            if worst <= 1.0 or 0.5 * best <= worst <= _ROUND_OFF_AT_MOST:
                return RitzVectors(vectors - block, count, solves)
            best = min(best, worst)
            block = block[:, errors > tolerances]
        if not space.grew:  # an invariant subspace, without all of a multiple eigenvalue
            block = np.hstack([block, precondition(mass(random()))])
            solves += width
        if space.size + block.shape[1] > limit:
            if restarts == max_restarts:
                done = sought - len(moving)
                raise EigenSolveError(
                    f"{done} of {count} modes converged after {restarts} restarts; "
                    "ask for fewer modes, or loosen the tolerance"
                )
            restarts += 1
            space.restart(values, inner, min(len(values) - 1, sought + width))
        space.extend(block)


def _moving(values: Array, before: Array, count: int, top: float) -> NDArray[np.intp]:
    """Places of the pairs that the last step still moved, lowest first."""
    change = np.full(len(values), np.inf)
    known = min(len(values), len(before))
    size = np.maximum(np.abs(values[:known]), np.finfo(float).tiny)
    change[:known] = np.abs(values[:known] - before[:known]) / size
    still = np.where(np.arange(len(values)) < count, _STILL, _GUARD_STILL)
    # Round-off of the projected matrix is relative to its largest value.
    still[:known] = np.maximum(still[:known], 10.0 * np.finfo(float).eps * top / size)
    return np.flatnonzero(change > still)


class _Space:
    """M-orthonormal vectors V with K V and Vᵀ K V."""

    def __init__(
        self, rows: int, columns: int, stiffness: BlockMap, mass: BlockMap, comm: MPI.Comm
    ) -> None:
        self._vectors = np.empty((rows, columns), order="F")
        self._images = np.empty((rows, columns), order="F")
        self._stiffness = stiffness
        self._mass = mass
        self._comm = comm
        self.size = 0
        self.grew = False
        self.projected = np.zeros((0, 0))

    def combine(self, coefficients: Array) -> Array:
        return _combined(self._vectors[:, : self.size], coefficients)

    def residuals(self, values: Array, inner: Array) -> tuple[Array, Array]:
        """Ritz vectors X and K X - M X θ."""
        vectors = self.combine(inner)
        forces = _combined(self._images[:, : self.size], inner)
        forces -= self._mass(vectors) * values
        return vectors, forces

    def extend(self, block: Array) -> Array:
        """Orthonormalise a block against the basis and itself, and add what is new of it.

        Returns:
            its coordinates (size, b) in the basis.
        """
        size, vectors = self.size, self._vectors[:, : self.size]
        product = self._mass(block)
        whole = left = self.sum(np.einsum("ij,ij->j", block, product))
        along = np.zeros((size, block.shape[1]))
        for _ in range(2 if size else 0):
            step = self.sum(vectors.T @ product)
            block = block - _combined(vectors, step)
            along += step
            product = self._mass(block)
            rest = self.sum(np.einsum("ij,ij->j", block, product))
            stable, left = (rest > _SHRUNK**2 * left).all(), rest
            if stable:
                break
        new = left > _DEPENDENT**2 * whole
        fresh, across = self._orthonormal(block[:, new], product[:, new])
        self.size = size + fresh.shape[1]
        self.grew = self.size > size
        self._vectors[:, size : self.size] = fresh
        self._images[:, size : self.size] = self._stiffness(fresh)
        self._project(size)
        coordinates = np.zeros((self.size, block.shape[1]))
        coordinates[:size] = along
        coordinates[size:, new] = across
        return coordinates

    def _project(self, old: int) -> None:
        images = self._images[:, old : self.size]
        coefficients = self.sum(self._vectors[:, : self.size].T @ images)
        grown = np.zeros((self.size, self.size))
        grown[:old, :old] = self.projected
        grown[:, old:] = coefficients
        grown[old:, :] = coefficients.T
        grown[old:, old:] = 0.5 * (coefficients[old:] + coefficients[old:].T)
        self.projected = grown

    def _orthonormal(self, block: Array, product: Array) -> tuple[Array, Array]:
        """Q and R with block = Q R and Q orthonormal in M; dependent columns go."""
        total = np.eye(block.shape[1])
        for _ in range(2):
            gram = self.sum(block.T @ product)
            scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
            values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
            keep = values > 1e-14 * len(values)
            root = np.sqrt(values[keep])
            turn = vectors[:, keep] / scale[:, None] / root
            block, product = _combined(block, turn), _combined(product, turn)
            total = (root[:, None] * vectors[:, keep].T * scale) @ total
        return block, total

    def restart(self, values: Array, inner: Array, keep: int) -> None:
        """Replace the basis by its first Ritz vectors."""
        for table in (self._vectors, self._images):
            table[:, :keep] = _combined(table[:, : self.size], inner[:, :keep])
        self.size = keep
        self.projected = np.diag(values[:keep])

    def sum(self, local: Array) -> Array:
        local = np.ascontiguousarray(local)
        self._comm.Allreduce(MPI.IN_PLACE, local, op=MPI.SUM)
        return local


def _combined(columns: Array, coefficients: Array) -> Array:
    """``columns @ coefficients`` in Fortran order, twice as fast as NumPy's own order of it."""
    return (coefficients.T @ columns.T).T
