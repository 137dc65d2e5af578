"""Coordinates at which a cubature is trained."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

from fenics_defo.errors import DefoError
from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.candidates import LawPoints, some_points, volumes
from fenics_defo.reduction.gram_tabulation import derivatives_of_gram
from fenics_defo.reduction.strain_columns import StrainColumns
from fenics_defo.runtime.forces import CubicForce
from fenics_defo.runtime.forces.symmetric import diagonal_weights
from fenics_defo.runtime.laws.kernel import IDENTITY

Array = NDArray[np.float64]

# Points of the stand-in whose equilibria are sampled: it need not be exact.
_SAMPLE = 3000
_BLOCK = 256
_ROUNDS = 30
_GROWTH, _LEVELS, _NEWTON = 1.4, 24, 12


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Training poses.

    Args:
        coordinates: (t, r).
        strains: largest ‖Fᵀ F − I‖ / 2 of each (t,) [-].
        redrawn: number of poses that were drawn again because a cell was inside out.
    """

    coordinates: Array
    strains: Array
    redrawn: int


class PoseSampler:
    """Random poses of a body; collective, the same on each rank.

    Args:
        groups: this rank's candidates.
        comm: communicator.
        random: of the same state on each rank.
    """

    def __init__(
        self, groups: tuple[LawPoints, ...], comm: MPI.Comm, random: np.random.Generator
    ) -> None:
        self._groups, self._comm, self._random = groups, comm, random
        #: Number of coordinates r.
        self.size: int = groups[0].gradients.shape[2]
        self._values, self._vectors = np.linalg.eigh(rest_stiffness(groups, comm))
        if not self._values[0] > 0.0:
            raise DefoError(
                "the basis can move the body without straining it, so that training poses have no "
                "scale; leave rigid motions out of the basis"
            )
        self._few = tuple(self._sample())
        self._stand_in: CubicForce | None = None

    def sampled(self, count: int, strain: float) -> Cloud:
        """Random coordinates of the modes of the reduced body, each scaled by λ₁/λ_i.

        Args:
            count: number of poses t.
            strain: largest strain of each is drawn evenly up to this [-].
        """
        return self._drawn(count, strain, lambda targets: self._scaled(targets))

    def statics(self, count: int, strain: float) -> Cloud:
        """Equilibria under random loads, of the same linear response as `sampled`.

        The equilibria are those of a St. Venant-Kirchhoff body of the same moduli at rest, summed
        over some random points: unlike random coordinates, they bend without stretching.

        Args:
            count: number of poses t.
            strain: largest strain of each is drawn evenly up to this [-].
        """
        return self._drawn(count, strain, lambda targets: self._equilibria(targets))

    def measured(self, coordinates: Array) -> Cloud:
        """Poses that are given, with their strains.

        Raises:
            DefoError: a pose turns a cell inside out, or does not strain the body.
        """
        strains, smallest = self._extremes(coordinates, self._groups)
        bad = np.flatnonzero(~((smallest > 0.0) & (strains > 0.0)))
        if bad.size:
            raise DefoError(
                f"training pose {bad[0] + 1} of {len(coordinates)} turns a cell inside out or "
                f"leaves the body at rest (smallest det F {smallest[bad[0]]:.3g}, largest strain "
                f"{strains[bad[0]]:.3g}); leave such poses out"
            )
        return Cloud(coordinates, strains, 0)

    def _drawn(self, count: int, strain: float, draw: Callable[[Array], Array]) -> Cloud:
        """Poses whose cells all keep their orientation; others are drawn again."""
        kept, strains, redrawn = [np.zeros((0, self.size))], [np.zeros(0)], 0
        for _ in range(_ROUNDS):
            missing = count - sum(len(part) for part in kept)
            if missing == 0:
                return Cloud(np.concatenate(kept), np.concatenate(strains), redrawn)
            q = draw(strain * self._random.uniform(0.05, 1.0, missing))
            found, smallest = self._extremes(q, self._groups)
            good = (smallest > 0.0) & (found > 0.0)
            redrawn += int((~good).sum())
            kept.append(q[good])
            strains.append(found[good])
        raise DefoError(
            f"{redrawn} training poses of strains up to {strain:.3g} turned cells inside out; "
            "train to a smaller strain, or give poses of an example motion"
        )

    def _scaled(self, targets: Array) -> Array:
        q = self._responses(len(targets))
        for _ in range(4):  # strains grow faster than the coordinates
            strain, _ = self._extremes(q, self._few)
            q *= (targets / strain)[:, None]
        return q

    def _responses(self, count: int) -> Array:
        """Random linear responses (t, r), each mode scaled by λ₁/λ_i."""
        scale = self._values[0] / self._values
        z = self._random.standard_normal((count, self.size)) * scale
        return z @ self._vectors.T

    def _equilibria(self, targets: Array) -> Array:
        """Equilibria at which the loads, growing step by step, have reached the strains."""
        law = self._stand_in = self._stand_in or self._tabulated()
        q = self._responses(len(targets))
        strain, _ = self._extremes(q, self._few)
        loads = q * (0.3 * targets / strain)[:, None]
        loads = ((loads @ self._vectors) * self._values) @ self._vectors.T
        q = np.zeros_like(loads)
        best = q.copy()
        active = np.arange(len(targets))
        factor = 1.0
        for _ in range(_LEVELS):
            q[active], converged = _newton(law, q[active], factor * loads[active])
            strain, smallest = self._extremes(q[active], self._few)
            good = converged & (strain <= targets[active]) & (smallest > 0.0)
            best[active[good]] = q[active[good]]
            active = active[good]
            if not active.size:
                break
            factor *= _GROWTH
        return best

    def _tabulated(self) -> CubicForce:
        """St. Venant-Kirchhoff with the laws' moduli at rest, over a random part of the points."""
        r = self.size
        columns = r + r * (r + 1) // 2
        gram = np.zeros((columns, columns), order="F")
        strain_columns = StrainColumns(r, _BLOCK, pairs=True)
        for points in self._few:
            for begin in range(0, len(points.weights), _BLOCK):
                some = some_points(points, np.arange(begin, len(points.weights))[:_BLOCK])
                fields = np.ascontiguousarray(some.gradients.transpose(2, 1, 0))
                A = strain_columns(fields.reshape(r, 3, 3, -1), some.weights, *_moduli(some))
                A = A.reshape(columns, -1)
                gram = dsyrk(1.0, A.T, beta=1.0, c=gram, trans=1, overwrite_c=1)
        whole = np.empty_like(gram)
        self._comm.Allreduce(gram, whole)
        whole += np.triu(whole, 1).T
        rest = derivatives_of_gram(whole, r)
        return CubicForce(rest.second, rest.third, rest.fourth * diagonal_weights(r))

    def _sample(self) -> Iterator[LawPoints]:
        """Some candidates, their weights scaled up to the whole body's.

        They are drawn by number, so that any number of ranks takes the same ones.
        """
        total = self._comm.allreduce(sum(len(points.weights) for points in self._groups))
        share = min(1.0, _SAMPLE / total)
        largest = max((int(p.numbers.max(initial=-1)) for p in self._groups), default=-1)
        draws = self._random.uniform(size=self._comm.allreduce(largest, op=MPI.MAX) + 1)
        for points in self._groups:
            few = some_points(points, draws[points.numbers] <= share)
            yield replace(few, weights=few.weights / share)

    def _extremes(self, q: Array, groups: tuple[LawPoints, ...]) -> tuple[Array, Array]:
        """Largest strain and smallest det F (t,) over some candidates of all ranks."""
        strain, volume = np.zeros(len(q)), np.full(len(q), np.inf)
        for points in groups:
            own = volumes(points, q)
            strain, volume = np.maximum(strain, own[0]), np.minimum(volume, own[1])
        largest, smallest = np.empty_like(strain), np.empty_like(volume)
        self._comm.Allreduce(strain, largest, op=MPI.MAX)
        self._comm.Allreduce(volume, smallest, op=MPI.MIN)
        return largest, smallest


def rest_tangents(points: LawPoints) -> Array:
    """∂P/∂F (n, 9, 9) [Pa] at rest of a law's candidates."""
    kernel = points.law.kernel(list(points.parameters), len(points.weights))
    kernel.gradients[:] = IDENTITY[:, None]
    with np.errstate(all="ignore"):
        return kernel.stress_and_tangent()[1]


def rest_stiffness(groups: tuple[LawPoints, ...], comm: MPI.Comm) -> Array:
    """The reduced stiffness at rest (r, r) by all candidates; collective."""
    r = groups[0].gradients.shape[2]
    local = np.zeros((r, r))
    for points in groups:
        for begin in range(0, len(points.weights), 4 * _BLOCK):
            some = some_points(points, np.arange(begin, len(points.weights))[: 4 * _BLOCK])
            image = rest_tangents(some) @ some.gradients * some.weights[:, None, None]
            local += some.gradients.reshape(-1, r).T @ image.reshape(-1, r)
    total = np.empty_like(local)
    comm.Allreduce(local, total)
    return 0.5 * (total + total.T)


def _moduli(points: LawPoints) -> tuple[Array, Array]:
    """λ and μ [Pa] at rest of candidates; of a law with directions, along two axes."""
    A = rest_tangents(points)
    mu = np.abs(A[:, 1, 1])
    mu = np.maximum(mu, 1e-6 * np.abs(A[:, 0, 0]))
    return np.maximum(A[:, 0, 0] - 2.0 * mu, 0.0), mu


def _newton(law: CubicForce, q: Array, loads: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Equilibria (t, r) of all poses at once, and which of them were found."""
    size = np.linalg.norm(loads, axis=1)
    q = q.copy()
    for _ in range(_NEWTON):
        residual = law.force(q) - loads
        if (np.linalg.norm(residual, axis=1) <= 1e-6 * size).all():
            break
        step = np.linalg.solve(law.stiffness(q), residual[..., None])[..., 0]
        q -= np.nan_to_num(step, nan=0.0, posinf=0.0, neginf=0.0)
    residual = law.force(q) - loads
    found: NDArray[np.bool_] = np.linalg.norm(residual, axis=1) <= 1e-3 * size
    return q, found
