"""Greedy choice of points, with non-negative weights, that reproduce the forces of the poses."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.candidates import LawPoints, some_points, stresses
from fenics_defo.reduction.cubature.nonnegative import GrowingLeastSquares

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Random subsets in a row without a candidate that helps, after which there is none.
_FUTILE = 5
_BLOCK = 1024


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
        curve: how the errors fell.
        is_complete: whether the error or the number of points that was asked for was reached.
    """

    numbers: IntArray
    weights: Array
    curve: Curve
    is_complete: bool


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Coordinates, the exact reduced forces there, and the candidates' answers.

    Args:
        coordinates: (t, r).
        forces: (t, r), none of them zero.
        answers: P (n, t, 9) of this rank's candidates, one array a law; none where they are not
            stored.
    """

    coordinates: Array
    forces: Array
    answers: tuple[Array, ...] = ()

    @property
    def sizes(self) -> Array:
        """Norms of the forces (t,)."""
        return np.linalg.norm(self.forces, axis=1)


class Pool:
    """The candidates of all ranks by their numbers; its methods are collective.

    Args:
        groups: this rank's candidates, one group a law.
        training: poses.
        comm: communicator.
    """

    def __init__(self, groups: tuple[LawPoints, ...], training: Poses, comm: MPI.Comm) -> None:
        self._groups, self._training, self._comm = groups, training, comm
        largest = max((int(g.numbers.max(initial=-1)) for g in groups), default=-1)
        #: Number of candidates on all ranks.
        self.size = comm.allreduce(largest, op=MPI.MAX) + 1
        self._group = np.full(self.size, -1)
        self._place = np.zeros(self.size, np.int64)
        for number, points in enumerate(groups):
            self._group[points.numbers] = number
            self._place[points.numbers] = np.arange(len(points.numbers))
        scale = 1.0 / training.sizes
        self._norms = [
            np.concatenate([np.zeros(0), *self._block_norms(points, answers, scale)])
            for points, answers in zip(groups, training.answers, strict=True)
        ]

    def best(self, numbers: IntArray, residual: Array, count: int) -> list[int]:
        """Up to ``count`` of some candidates whose columns are most along a residual (t, r)."""
        own = numbers[self._group[numbers] >= 0]
        scores = np.full(len(own), -np.inf)
        along = residual / self._training.sizes[:, None]
        for group, (points, answers) in enumerate(
            zip(self._groups, self._training.answers, strict=True)
        ):
            chosen = np.flatnonzero(self._group[own] == group)
            for begin in range(0, len(chosen), _BLOCK):
                some = chosen[begin : begin + _BLOCK]
                places = self._place[own[some]]
                pulled = points.gradients[places] @ along.T  # (k, 9, t)
                products = np.einsum("kct,ktc->k", pulled, answers[places])
                norms = self._norms[group][places]
                scores[some] = np.divide(
                    products, norms, out=np.full(len(some), -np.inf), where=norms > 0.0
                )
        first = np.lexsort((own, -scores))[:count]
        found = [(float(scores[k]), int(own[k])) for k in first if scores[k] > 0.0]
        ranked = sorted(
            (pair for pairs in self._comm.allgather(found) for pair in pairs),
            key=lambda pair: (-pair[0], pair[1]),
        )
        return [number for _, number in ranked[:count]]

    def columns(self, numbers: list[int], poses: Poses) -> Array:
        """Forces of some candidates of unit weight, over the norms of the whole (k, t r).

        Args:
            numbers: theirs.
            poses: where.
        """
        r = poses.coordinates.shape[1]
        local = np.zeros((len(numbers), len(poses.coordinates), r))
        for row, number in enumerate(numbers):
            group = self._group[number]
            if group < 0:
                continue
            place = self._place[number]
            points = self._groups[group]
            if poses.answers:
                stress = poses.answers[group][place]
            else:
                stress = stresses(some_points(points, np.array([place])), poses.coordinates)[0]
            local[row] = stress @ points.gradients[place]
        local /= poses.sizes[:, None]
        total = np.empty_like(local)
        self._comm.Allreduce(local, total)
        return total.reshape(len(numbers), -1)

    def _block_norms(self, points: LawPoints, answers: Array, scale: Array) -> list[Array]:
        norms = []
        for begin in range(0, len(points.weights), _BLOCK):
            part = slice(begin, begin + _BLOCK)
            forces = answers[part] @ points.gradients[part]
            forces *= scale[:, None]
            norms.append(np.sqrt(np.einsum("ktr,ktr->k", forces, forces)))
        return norms


def select(
    pool: Pool,
    training: Poses,
    held_out: Poses,
    *,
    tolerance: float,
    most: int,
    subset: int | None,
    random: np.random.Generator,
    observe: Callable[[int, float, float], None] | None = None,
) -> Selection:
    """Add the candidate that reduces the residual most, and solve for the weights, again and again.

    With random subsets this is An, Kim and James's training (2008); with all candidates each time
    it is the sparse non-negative least squares of energy-conserving sampling and weighting, ended
    at the tolerance (Farhat et al., IJNME 98, 2014; Chapman et al., IJNME 109, 2017). Collective;
    the same on any number of ranks, but for round-off. An interruption from the keyboard ends it
    with the set that was reached.

    Args:
        pool: candidates.
        training: poses that the weights are fitted to.
        held_out: poses that only judge.
        tolerance: error at the training poses at which to stop [-].
        most: number of points at which to stop.
        subset: number of candidates looked at for each point; None for all.
        random: where subsets come from.
        observe: called with the number of points and the two errors.
    """
    target = (training.forces / training.sizes[:, None]).ravel()
    judged = (held_out.forces / held_out.sizes[:, None]).ravel()
    fit, elsewhere = GrowingLeastSquares(target), dict[int, Array]()
    rows: list[tuple[int, float, float]] = []
    futile, reached = 0, False
    try:
        while not reached and futile < _FUTILE:
            numbers = _drawn(pool.size, subset, random)
            numbers = np.setdiff1d(numbers, np.array(fit.keys, np.int64))
            found = pool.best(numbers, fit.residual.reshape(training.forces.shape), 1)
            if not found:
                futile += 1 if subset is not None and subset < pool.size else _FUTILE
                continue
            fit.add(found, pool.columns(found, training))
            elsewhere[found[0]] = pool.columns(found, held_out)[0]
            futile = 0 if found[0] in fit.keys else futile + 1
            sums = fit.weights @ np.array([elsewhere[key] for key in fit.keys])
            errors = (
                float(np.linalg.norm(fit.residual) / np.linalg.norm(target)),
                float(np.linalg.norm(judged - sums) / np.linalg.norm(judged)),
            )
            rows.append((len(fit.keys), *errors))
            if observe:
                observe(*rows[-1])
            reached = errors[0] <= tolerance or len(fit.keys) >= most
    except KeyboardInterrupt:
        pass
    order = np.argsort(fit.keys)
    points, first, second = (
        (np.array(column) for column in zip(*rows, strict=True))
        if rows
        else (
            np.zeros(0, np.int64),
            np.zeros(0),
            np.zeros(0),
        )
    )
    return Selection(
        numbers=np.array(fit.keys, np.int64)[order],
        weights=fit.weights[order],
        curve=Curve(points, first, second),
        is_complete=reached,
    )


def _drawn(size: int, subset: int | None, random: np.random.Generator) -> IntArray:
    if subset is None or subset >= size:
        return np.arange(size)
    return random.choice(size, subset, replace=False)
