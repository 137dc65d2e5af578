"""Choice of points, with non-negative weights, that reproduce the forces of the poses."""

import time
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.interruption import Interruption
from fenics_defo.reduction.cubature.nonnegative import GrowingLeastSquares
from fenics_defo.reduction.cubature.pool import Pool, Poses
from fenics_defo.reduction.cubature.progress import Observer, Progress, seconds_left

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Random subsets in a row without a candidate that helps, after which there is none.
_FUTILE = 5
# Thinning: points are added until the error is this part of the tolerance, then the cheapest leave.
_OVERSHOOT, _SURPLUS = 0.8, 1.15


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Errors of the growing set: ‖f̂ − f‖ / ‖f‖, root mean square over the poses.

    Args:
        points: number of points (s,).
        training: error at the training poses (s,).
        held_out: error at the held-out poses (s,).
    """

    points: IntArray
    training: Array
    held_out: Array


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """Points and weights.

    Args:
        numbers: of the chosen candidates (p,), ascending.
        weights: theirs (p,) [m³], positive.
        training: error at the training poses [-].
        held_out: error at the held-out poses [-].
        curve: how the errors fell as points were added, before any were taken away again.
        is_interrupted: whether Ctrl-C ended it.
    """

    numbers: IntArray
    weights: Array
    training: float
    held_out: float
    curve: Curve
    is_interrupted: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How points are looked for.

    Args:
        subset: number of random candidates looked at for each point; None for all.
        finalists: those of them that are most along the residual, of which the one that takes most
            off it in orthogonal projection is added; with 1 it is simply the first.
        rounds: how often points are added beyond the tolerance and the cheapest taken away.
    """

    subset: int | None
    finalists: int = 1
    rounds: int = 0


def select(
    pool: Pool,
    training: Poses,
    held_out: Poses,
    *,
    tolerance: float,
    most: int,
    search: Search,
    random: np.random.Generator,
    comm: MPI.Comm,
    observe: Observer | None = None,
) -> Selection:
    """Add the candidate that reduces the residual most, and solve for the weights, again and again.

    With random subsets this is An, Kim and James's training (2008); with all candidates each time
    it is the sparse non-negative least squares of energy-conserving sampling and weighting, ended
    at the tolerance (Farhat et al., IJNME 98, 2014; Chapman et al., IJNME 109, 2017). Collective;
    the same on any number of ranks, but for round-off. An interruption from the keyboard ends it
    with the best set that was reached.

    Args:
        pool: candidates.
        training: poses that the weights are fitted to.
        held_out: poses that only judge.
        tolerance: error at the training poses at which to stop [-].
        most: number of points at which to stop.
        search: how.
        random: where subsets come from.
        comm: communicator.
        observe: called with the progress.

    Raises:
        KeyboardInterrupt: before there was a point.
    """
    run = _Run(pool, training, held_out, search, random)
    with Interruption(comm) as interruption:
        record = _Record(tolerance, most, observe, interruption)
        while not run.is_done(tolerance, most) and not interruption.asked() and run.grow():
            record.add(run)
        best = run.fit
        for _ in range(search.rounds if len(best.keys) else 0):
            if interruption.asked():
                break
            best = run.thinned(best, tolerance, most)
    if not best.keys:
        raise KeyboardInterrupt
    order = np.argsort(best.keys)
    return Selection(
        numbers=np.array(best.keys, np.int64)[order],
        weights=best.weights[order],
        training=best.error,
        held_out=run.judged(best),
        curve=record.curve(),
        is_interrupted=interruption.heard,
    )


class _Run:
    """A set of points that grows and is thinned; collective."""

    def __init__(
        self,
        pool: Pool,
        training: Poses,
        held_out: Poses,
        search: Search,
        random: np.random.Generator,
    ) -> None:
        self._pool, self._search, self._random = pool, search, random
        self._training, self._held_out = training, held_out
        self._judged = (held_out.forces / held_out.sizes[:, None]).ravel()
        self._elsewhere: dict[int, Array] = {}
        self.fit = GrowingLeastSquares((training.forces / training.sizes[:, None]).ravel())

    def is_done(self, tolerance: float, most: int) -> bool:
        """Whether the error or the number of points has been reached."""
        return len(self.fit.keys) >= most or self.fit.error <= tolerance

    def grow(self) -> bool:
        """Add a point; False if none helps."""
        subset, size = self._search.subset, self._pool.size
        draws = subset is not None and subset < size
        for _ in range(_FUTILE if draws else 1):
            drawn = self._random.choice(size, subset, replace=False) if draws else np.arange(size)
            drawn = np.setdiff1d(drawn, np.array(self.fit.keys, np.int64))
            residual = self.fit.residual.reshape(self._training.forces.shape)
            found = self._pool.best(drawn, residual, self._search.finalists)
            if not len(found):
                continue
            columns = self._pool.columns(found, self._training)
            best = int(np.argmax(self.fit.gains(columns))) if len(found) > 1 else 0
            key = int(found[best])
            self.fit.add([key], columns[best : best + 1])
            if key in self.fit.keys:
                self._elsewhere[key] = self._pool.columns(found[best : best + 1], self._held_out)[0]
                return True
        return False

    def judged(self, fit: GrowingLeastSquares) -> float:
        """Error at the held-out poses."""
        sums = fit.weights @ np.array([self._elsewhere[key] for key in fit.keys])
        return float(np.linalg.norm(self._judged - sums) / np.linalg.norm(self._judged))

    def thinned(
        self, best: GrowingLeastSquares, tolerance: float, most: int
    ) -> GrowingLeastSquares:
        """The set with some more points and then without the cheapest, if that is better."""
        self.fit = copy(best)
        surplus = int(np.ceil(_SURPLUS * len(best.keys))) + 1
        while not self.is_done(_OVERSHOOT * tolerance, surplus) and self.grow():
            pass
        fit = self.fit
        while len(fit.keys) > 1:
            fewer = fit.without_cheapest()
            if len(fit.keys) <= most and not fewer.error <= tolerance:
                break
            fit = fewer
        return min(best, fit, key=lambda one: (max(one.error, tolerance), len(one.keys)))


class _Record:
    """Errors after each point, told to whom it may concern."""

    def __init__(
        self, tolerance: float, most: int, observe: Observer | None, interruption: Interruption
    ) -> None:
        self._tolerance, self._most = tolerance, most
        self._observe, self._interruption = observe, interruption
        self._rows: list[tuple[int, float, float]] = []
        self._begin = time.perf_counter()
        self._seconds: list[float] = []

    def add(self, run: _Run) -> None:
        """Note the state after a point was added."""
        row = len(run.fit.keys), run.fit.error, run.judged(run.fit)
        self._rows.append(row)
        self._seconds.append(time.perf_counter() - self._begin)
        if self._observe is None:
            return
        errors = [error for _, error, _ in self._rows]
        left = seconds_left(errors, self._seconds, self._tolerance, self._most)
        told = Progress(
            points=row[0],
            training=row[1],
            held_out=row[2],
            seconds=self._seconds[-1],
            seconds_left=left,
        )
        try:
            self._observe(told)
        except KeyboardInterrupt:
            self._interruption.note()

    def curve(self) -> Curve:
        """All that was noted."""
        points, training, held_out = zip(*self._rows, strict=True)
        return Curve(np.array(points), np.array(training), np.array(held_out))
