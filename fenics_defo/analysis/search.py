"""The search for the lowest pairs: whole clusters, and a count that proves none is missing."""

import logging
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.davidson import BLOCK
from fenics_defo.analysis.deflation import Deflation
from fenics_defo.analysis.eigenpairs import Pairs
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.slepc import krylov_schur
from fenics_defo.analysis.spectrum import cluster_end
from fenics_defo.analysis.stability import not_stable
from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]
Solver = Literal["davidson", "krylov-schur", "iterative"]

_log = logging.getLogger(__name__)

# About a deformed state: λ of a motion without stiffness, relative to the estimate of the first
# other one. ω is 1e-4 of it.
_ZERO = 1e-8
# Pairs computed beyond those asked for: they show where a cluster ends and where to count.
_GUARD = 2
_ATTEMPTS = 4
# λ that differ by less are one eigenvalue, found with different round-off.
_EQUAL = 1e-6
# Error bound of the vectors of the shifted and inverted problem; that of λ is its square.
_TOLERANCE = 1e-7


@dataclass(frozen=True, slots=True)
class Search:
    """The search for the lowest ``count`` pairs and what completes their last cluster.

    Args:
        deflation: the problem and its strainless motions.
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

    deflation: Deflation
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
        wanted = max(first, self.strainless + 1)
        end, expected, deflation = 0, 0, self.deflation
        for attempt in range(_ATTEMPTS):
            pairs, end = self._whole_clusters(deflation, wanted, self.seed + attempt)
            cut, kept = _cut(pairs.values, end), pairs.leading(end)
            if not verify:
                return kept, False
            with self.phases("count"):
                expected = self.deflation.problem.below(cut)
            if expected == end:
                return kept, True
            _log.info("found %d modes where the inertia counts %d: searching on", end, expected)
            wanted = max(expected, end) + _GUARD
            deflation = self.deflation.locking(pairs) if expected > end else self.deflation
        raise EigenSolveError(
            f"{end} modes were found where the inertia of the shifted stiffness counts {expected}, "
            f"in {_ATTEMPTS} attempts; ask for a few more or fewer modes, or check the mesh for "
            "parts that hardly hold together"
        )

    def _whole_clusters(self, deflation: Deflation, wanted: int, seed: int) -> tuple[Pairs, int]:
        """Pairs, and how many of them the count and its last cluster take."""
        most, settled = self.deflation.problem.independent, 0
        while True:
            pairs = self._cleaned(self._solve(deflation, min(wanted, most), seed))
            found, zeros = len(pairs.values), int(np.count_nonzero(pairs.values == 0.0))
            total = self.count + (0 if self.keep_rigid else zeros)
            end = cluster_end(pairs.values, total, rtol=self.cluster_rtol) if total <= found else 0
            if found >= most:
                return pairs, end
            if 0 < end < found and end <= pairs.converged:
                # One search sees an eigenvalue as often as a block has vectors; where it did, it
                # is searched again without what is known, until nothing new appears.
                if end == settled or not _crowded(pairs.values[:end]):
                    return pairs, end
                settled = end
            deflation = self.deflation.locking(pairs)
            wanted = max(found, wanted) + wanted // 4 + 1
            seed += _ATTEMPTS

    def _cleaned(self, pairs: Pairs) -> Pairs:
        """The pairs with 0 for what is 0 but for round-off.

        Raises:
            EigenSolveError: an eigenvalue is negative.
        """
        tiny = 0.0 if self.deflation.problem.definite else _ZERO * self.scale
        negative = int(np.count_nonzero(pairs.values < -tiny))
        if negative:
            raise not_stable(negative)
        return replace(pairs, values=np.where(pairs.values <= tiny, 0.0, pairs.values))

    def _solve(self, deflation: Deflation, count: int, seed: int) -> Pairs:
        """About ``count`` pairs, those known already included."""
        known = deflation.problem.independent - deflation.remaining
        need = min(max(1, count - known), deflation.remaining)
        return deflation.whole(self._remaining(deflation, need, seed))

    def _remaining(self, deflation: Deflation, count: int, seed: int) -> Pairs:
        phases = self.phases
        match self.solver:
            case "davidson":
                return deflation.direct(
                    count, guard=_GUARD, tolerance=_TOLERANCE, seed=seed, phases=phases
                )
            case "krylov-schur":
                self._refuse_unstable()
                count = min(count + _GUARD, deflation.remaining)
                return krylov_schur(deflation, count, tolerance=_TOLERANCE, phases=phases)
        return deflation.multigrid(
            count,
            self.near_kernel,
            guard=_GUARD,
            tolerance=_TOLERANCE,
            seed=seed,
            phases=phases,
        )

    def _refuse_unstable(self) -> None:
        """SLEPc's factors are not ours to ask, and it takes values on both sides of the shift."""
        problem = self.deflation.problem
        if problem.definite:
            return
        with self.phases("count"):
            negative = problem.below(problem.shift or -_ZERO * self.scale)
        if negative:
            raise not_stable(negative)


def _crowded(values: Array) -> bool:
    """Whether as many equal values above 0 follow each other as a block has vectors."""
    values = values[values > 0.0]
    same = np.diff(values) <= _EQUAL * values[1:]
    ends = np.flatnonzero(np.concatenate([[True], ~same, [True]])) if values.size else np.zeros(1)
    return bool(np.diff(ends).max(initial=0) >= BLOCK)


def _cut(values: Array, end: int) -> float:
    """A value between the last kept eigenvalue and the next; above all if there is no next."""
    if end < len(values):
        return 0.5 * float(values[end - 1] + values[end])
    return 1.01 * float(values[-1])
