"""Every candidate of a body by its number, on whatever rank it is, and its part of the forces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.candidates import LawPoints, some_points, stresses

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_BLOCK = 1024


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Coordinates, the exact reduced forces there, and the candidates' answers.

    Args:
        coordinates: (t, r).
        forces: (t, r), none of them zero.
        answers: P (n, 9, t) of this rank's candidates, one array a law; none where they are not
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

    def best(self, numbers: IntArray, residual: Array, count: int) -> IntArray:
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
                pulled *= answers[places]
                products = pulled.sum(axis=(1, 2))
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
        return np.array([number for _, number in ranked[:count]], np.int64)

    def columns(self, numbers: IntArray, poses: Poses) -> Array:
        """Forces of some candidates of unit weight, over the norms of the whole (k, t r).

        Args:
            numbers: theirs.
            poses: where.
        """
        r = poses.coordinates.shape[1]
        local = np.zeros((len(numbers), len(poses.coordinates), r))
        for group, points in enumerate(self._groups):
            rows = np.flatnonzero(self._group[numbers] == group)
            places = self._place[numbers][rows]
            if poses.answers:
                stress = poses.answers[group][places]
            else:
                stress = stresses(some_points(points, places), poses.coordinates)
            local[rows] = stress.transpose(0, 2, 1) @ points.gradients[places]
        local /= poses.sizes[:, None]
        total = np.empty_like(local)
        self._comm.Allreduce(local, total)
        return total.reshape(len(numbers), -1)

    def _block_norms(self, points: LawPoints, answers: Array, scale: Array) -> list[Array]:
        norms = []
        for begin in range(0, len(points.weights), _BLOCK):
            part = slice(begin, begin + _BLOCK)
            forces = answers[part].transpose(0, 2, 1) @ points.gradients[part]
            forces *= scale[:, None]
            norms.append(np.sqrt(np.einsum("ktr,ktr->k", forces, forces)))
        return norms
