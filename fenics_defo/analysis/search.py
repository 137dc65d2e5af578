"""The search for the lowest pairs: whole clusters, and a count that proves none is missing."""

import logging
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.deflation import FreeBody
from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.slepc import krylov_schur
from fenics_defo.analysis.spectrum import cluster_end
from fenics_defo.analysis.stability import not_stable
from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]
Solver = Literal["lanczos", "krylov-schur", "iterative"]

_log = logging.getLogger(__name__)

# About a deformed state: λ of a motion without stiffness, relative to the estimate of the first
# other one. ω is 1e-4 of it.
_ZERO = 1e-8
# Pairs computed beyond those asked for: they show where a cluster ends and where to count.
_GUARD = 2
_ATTEMPTS = 4
# Error of the shifted and inverted eigenvalues: the residuals stay near the factors' round-off.
_TOLERANCE = 1e-11
_ITERATIVE_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Search:
    """The search for the lowest ``count`` pairs and what completes their last cluster.

    Args:
        problem: matrices and shift.
        free: the strainless motions, if the body has some.
        near_kernel: (owned dofs, 6) rigid motions of the whole, zero at held components.
        scale: estimate of the first elastic λ about a deformed state [rad²/s²].
        strainless: number of λ that are expected to be zero.
        solver: how to find pairs.
        count: number of pairs.
        keep_rigid: whether λ = 0 belongs to the count.
        cluster_rtol: relative distance of λ that count as equal.
        seed: of the random start vectors.
        phases: stopwatch.
    """

    problem: EigenProblem
    free: FreeBody | None
    near_kernel: Array
    scale: float
    strainless: int
    solver: Solver
    count: int
    keep_rigid: bool
    cluster_rtol: float
    seed: int
    phases: Phases

    def run(self, *, verify: bool) -> tuple[Pairs, bool]:
        """Pairs, λ of strainless motions exactly 0, and whether a count proved them complete.

        Raises:
            EigenSolveError: the count never agreed with the pairs found, or λ < 0.
        """
        first = self.count if self.keep_rigid else self.count + self.strainless
        wanted = max(first, self.strainless) + _GUARD
        end = expected = 0
        for attempt in range(_ATTEMPTS):
            pairs, end = self._whole_clusters(wanted, self.seed + attempt)
            kept = Pairs(pairs.values[:end], pairs.vectors[:, :end])
            if not verify:
                return kept, False
            with self.phases("count"):
                expected = self.problem.below(_cut(pairs.values, end))
            if expected == end:
                return kept, True
            _log.info("found %d modes where the inertia counts %d: searching on", end, expected)
            wanted = max(expected, end) + _GUARD * (attempt + 2)
        raise EigenSolveError(
            f"{end} modes were found where the inertia of the shifted stiffness counts {expected}, "
            f"in {_ATTEMPTS} attempts; ask for a few more or fewer modes, or check the mesh for "
            "parts that hardly hold together"
        )

    def _whole_clusters(self, wanted: int, seed: int) -> tuple[Pairs, int]:
        """Pairs, and how many of them the count and its last cluster take."""
        while True:
            wanted = min(wanted, self.problem.independent)
            pairs = self._cleaned(self._solve(wanted, seed))
            found = len(pairs.values)
            zeros = 0 if self.keep_rigid else int(np.count_nonzero(pairs.values == 0.0))
            if self.count + zeros <= found:
                end = cluster_end(pairs.values, self.count + zeros, rtol=self.cluster_rtol)
                if end < found or found >= self.problem.independent:
                    return pairs, end
            wanted = 2 * found

    def _cleaned(self, pairs: Pairs) -> Pairs:
        """The pairs with 0 for what is 0 but for round-off.

        Raises:
            EigenSolveError: an eigenvalue is negative.
        """
        tiny = 0.0 if self.problem.definite else _ZERO * self.scale
        negative = int(np.count_nonzero(pairs.values < -tiny))
        if negative:
            raise not_stable(negative)
        return Pairs(np.where(pairs.values <= tiny, 0.0, pairs.values), pairs.vectors)

    def _solve(self, count: int, seed: int) -> Pairs:
        if self.free is None:
            return self._elastic(self.problem, count, seed)
        elastic = min(max(1, count - self.free.motions.shape[1]), self.free.elastic)
        return self.free.with_motions(self._elastic(self.free, elastic, seed))

    def _elastic(self, source: EigenProblem | FreeBody, count: int, seed: int) -> Pairs:
        phases = self.phases
        match self.solver:
            case "lanczos":
                return source.lanczos(count, tolerance=_TOLERANCE, seed=seed, phases=phases)
            case "krylov-schur":
                with phases("count"):  # SLEPc would take the values on both sides of the shift
                    negative = 0 if self.problem.definite else self.problem.below(self._lowest())
                if negative:
                    raise not_stable(negative)
                return krylov_schur(
                    self.problem, count, tolerance=_TOLERANCE, phases=phases, free=self.free
                )
        return source.multigrid_lanczos(
            count, self.near_kernel, tolerance=_ITERATIVE_TOLERANCE, seed=seed, phases=phases
        )

    def _lowest(self) -> float:
        """A value below all λ of a stable state, and not at the many that are 0."""
        return self.problem.shift if self.free is None else -_ZERO * self.scale


def _cut(values: Array, end: int) -> float:
    """A value between the last kept eigenvalue and the next; above all if there is no next."""
    if end < len(values):
        return 0.5 * float(values[end - 1] + values[end])
    return 1.01 * float(values[-1])
