"""Block Davidson iteration with thick restarts for the lowest eigenpairs of K x = θ M x.

The space grows by what a preconditioner makes of the residuals, T (K x - θ M x), and the pairs are
Ritz pairs of K and M themselves. With T = K⁻¹ this spans what inverted block Lanczos spans, step by
step; but T may be a rough inverse, since its errors are corrected by the next residuals: factors in
single precision, half as large and as dear as those in double precision, or a few cycles of
multigrid. With such a T the corrections also tell the error of x, as T (K x - θ M x) = x - θ T M x
is what another inverse iteration would change. Solving for a block of vectors reads the factors
once for all of them, which is what such a solve costs.

References: Davidson, J. Comput. Phys. 17 (1975) 87-94; Crouzeix, Philippe and Sadkane, SIAM J. Sci.
Comput. 15 (1994) 62-76 (block Davidson); Grimes, Lewis and Simon, SIAM J. Matrix Anal. Appl. 15
(1994) 228-272 (shifted block Lanczos).
"""

from collections.abc import Callable
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.ritz_space import RitzSpace
from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]
BlockMap = Callable[[Array], Array]

#: Vectors solved for at once: more of them read the factors less often, and are more in all.
BLOCK = 12

_GUARD_TOLERANCE = 1e-3
# Multiple of the tolerance at which errors may stagnate: the stiffness of long thin bodies is so
# ill-conditioned that no more can be had. The residuals of the pairs are judged by the caller.
_ROUND_OFF_AT_MOST = 1e5
# A step that moves θ by less, relative to it, moves x by less than the square root of it.
_STILL, _GUARD_STILL = 1e-13, 1e-6


class RoughPreconditionerError(EigenSolveError):
    """A preconditioner does not resemble an inverse of the stiffness."""


@dataclass(frozen=True, slots=True)
class SearchedProblem:
    """What the search knows of K x = θ M x.

    Args:
        precondition: X -> T X for a block (owned dofs, b), roughly K⁻¹ X, in that space.
        multiply: X -> K X and M X side by side (owned dofs, 2 b).
        residuals: X, θ (b,) -> K X - M X diag(θ).
        mass: X -> M X.
        random: gives a random block (owned dofs, b); b is the block size.
        comm: communicator of the rows.
        independent: dimension of the space.

    All blocks are in Fortran order.
    """

    precondition: BlockMap
    multiply: BlockMap
    residuals: Callable[[Array, Array], Array]
    mass: BlockMap
    random: Callable[[], Array]
    comm: MPI.Comm
    independent: int


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
    problem: SearchedProblem,
    count: int,
    *,
    guard: int = 0,
    tolerance: float = 1e-7,
    roughest: float = np.inf,
    basis_limit: int | None = None,
    max_restarts: int = 40,
) -> RitzVectors:
    """Lowest eigenvectors of K x = θ M x. Collective.

    Args:
        problem: K and M and what is nearly an inverse of K.
        count: number of pairs.
        guard: number of further pairs, to 1e-3 only: their θ, whose error is the square of that,
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
    return _Search(problem, count, guard, tolerance, basis_limit, max_restarts).run(roughest)


class _Search:
    """The state of a search."""

    def __init__(
        self,
        problem: SearchedProblem,
        count: int,
        guard: int,
        tolerance: float,
        basis_limit: int | None,
        max_restarts: int,
    ) -> None:
        self._problem = problem
        self._count, self._sought = count, min(count + guard, problem.independent)
        self._tolerances = np.where(np.arange(self._sought) < count, tolerance, _GUARD_TOLERANCE)
        self._start = problem.random()
        self._width = self._start.shape[1]
        self._limit = basis_limit or count + guard + max(count, 15 * self._width)
        columns = self._limit + self._sought + self._width
        self._space = RitzSpace(problem.multiply, problem.comm, len(self._start), columns)
        self._solves, self._restarts, self._max_restarts = 0, 0, max_restarts
        self._before, self._best = np.zeros(0), np.inf

    def run(self, roughest: float) -> RitzVectors:
        """The vectors; see `block_davidson`."""
        space, sought = self._space, self._sought
        space.extend(self._first_block(roughest))
        while True:
            values, inner = space.ritz()
            if space.size == self._problem.independent:  # the pairs are exact but for round-off
                return self._all(inner)
            moving = self._moving(values)
            testing = space.size >= sought and not moving.size
            chosen = np.arange(sought) if testing else moving[: self._width]
            vectors = space.combine(inner[:, chosen])
            block = self._precondition(self._problem.residuals(vectors, values[chosen]))
            if testing:
                errors = self._errors(block)
                if self._settled(errors):
                    return RitzVectors(vectors - block, self._count, self._solves)
                block = block[:, errors > self._tolerances]
            if not space.grew:  # an invariant subspace, without all of a multiple eigenvalue
                block = np.hstack([block, self._precondition(self._load())])
            if space.size + block.shape[1] > self._limit:
                self._restart(values, inner, sought - len(moving))
            space.extend(block)

    def _load(self) -> Array:
        return self._problem.mass(self._problem.random())

    def _precondition(self, block: Array) -> Array:
        self._solves += block.shape[1]
        return self._problem.precondition(block)

    def _first_block(self, roughest: float) -> Array:
        """T M times random vectors.

        Raises:
            RoughPreconditionerError: T is rougher than is tolerated.
        """
        load = self._problem.mass(self._start)
        block = self._precondition(load)
        images = self._problem.multiply(block)[:, : self._width]
        stiff, work = (self._dots(block, forces) for forces in (images, load))
        error = np.abs(stiff / work - 1.0).max()
        if not error <= roughest:
            raise RoughPreconditionerError(f"the preconditioner errs by {error:.1e}")
        return block

    def _moving(self, values: Array) -> NDArray[np.intp]:
        """Places of the sought pairs that the last step still moved, lowest first."""
        before, self._before = self._before, values
        places = np.arange(min(len(values), self._sought))
        known = min(len(places), len(before))
        change = np.full(len(places), np.inf)
        size = np.maximum(np.abs(values[: len(places)]), np.finfo(float).tiny)
        change[:known] = np.abs(values[:known] - before[:known]) / size[:known]
        still = np.where(places < self._count, _STILL, _GUARD_STILL)
        # Round-off of the projected matrix is relative to its largest value.
        noise = 10.0 * np.finfo(float).eps * float(values[-1])
        return places[change > np.maximum(still, noise / size)]

    def _errors(self, block: Array) -> Array:
        """Norms in M of a block's columns."""
        return np.sqrt(self._dots(block, self._problem.mass(block)))

    def _dots(self, left: Array, right: Array) -> Array:
        return self._space.sum(np.einsum("ij,ij->j", left, right))

    def _settled(self, errors: Array) -> bool:
        worst = float((errors / self._tolerances).max())
        # Round-off of K x is all that is left where another step no longer helps.
        if worst <= 1.0 or 0.5 * self._best <= worst <= _ROUND_OFF_AT_MOST:
            return True
        self._best = min(self._best, worst)
        return False

    def _all(self, inner: Array) -> RitzVectors:
        """All pairs of a space that is spanned whole."""
        independent = self._problem.independent
        if independent < self._count:
            raise EigenSolveError(
                f"the body has only {independent} independent motions, "
                f"and {self._count} modes were asked for"
            )
        return RitzVectors(self._space.combine(inner), independent, self._solves)

    def _restart(self, values: Array, inner: Array, done: int) -> None:
        if self._restarts == self._max_restarts:
            raise EigenSolveError(
                f"{done} of {self._count} modes converged after {self._restarts} restarts; "
                "ask for fewer modes, or loosen the tolerance"
            )
        self._restarts += 1
        keep = min(len(values) - 1, self._sought + self._width)
        self._space.restart(values[:keep], inner[:, :keep])
