"""Forces of any energy, summed over few weighted points: numerical cubature.

With the rows G_p (9, r) of the basis's gradients at point p, F_p = I + G_p q and weights w_p > 0,

    W = Σ_p w_p ψ(F_p),   f = Σ_p w_p G_pᵀ P(F_p),   K = Σ_p w_p G_pᵀ ∂P/∂F(F_p) G_p,

so that K is symmetric and f the gradient of W whatever the weights are. An, Kim and James,
Optimizing cubature for efficient integration of subspace deformations, ACM Transactions on
Graphics 27(5), 2008.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.forces.coordinates import by_batches, checked
from fenics_defo.runtime.forces.cubature_evaluators import (
    CubatureBatchEvaluator,
    CubatureEvaluator,
    PointGroup,
)
from fenics_defo.runtime.forces.law_tables import LAW_ARRAYS, pack_laws, unpack_laws
from fenics_defo.runtime.frozen import frozen_array, symmetric_array
from fenics_defo.runtime.laws import MaterialLaw
from fenics_defo.runtime.laws.kernel import IDENTITY

Array = NDArray[np.float64]

#: Numbers in the largest buffer of a batch: small enough to stay in a processor's cache.
_BUFFER = 1 << 18


@dataclass(frozen=True, slots=True, eq=False)
class CubatureForce:
    """Force of any material laws at p weighted points.

    Args:
        weights: w (p,) [m³], positive.
        gradients: G (p, 9, r), entry 3 i + j the derivative of component i along axis j [1/m].
        laws: material laws; the points of the first come first, then those of the next.
        counts: number of points of each law.
        parameters: for each law an array (its parameters, its points).
        correction: E (r, r), symmetric, added to K for good, with ½ qᵀ E q to W and E q to f: what
            the sum lacks of the stiffness at rest. None for none.

    Raises:
        ValueError: other shapes, weights that are not positive, or values that are not finite.
    """

    kind: ClassVar[str] = "cubature"
    ARRAYS: ClassVar[Mapping[str, ArraySpec]] = {
        "weights": ArraySpec("f", 1),
        "gradients": ArraySpec("f", 3),
        "correction": ArraySpec("f", 2),
        **LAW_ARRAYS,
    }

    weights: Array
    gradients: Array
    laws: tuple[MaterialLaw, ...]
    counts: tuple[int, ...]
    parameters: tuple[Array, ...]
    correction: Array | None = None
    _groups: tuple[PointGroup, ...] = field(init=False, repr=False)
    _level: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = np.shape(self.weights)[0] if np.ndim(self.weights) == 1 else 0
        weights = frozen_array("weights", self.weights, (points,))
        if points == 0 or not (weights > 0.0).all():
            raise ValueError("a cubature needs at least one point, and weights that are positive")
        r = np.shape(self.gradients)[2] if np.ndim(self.gradients) == 3 else 0
        if r == 0:
            raise ValueError(f"gradients must have the shape ({points}, 9, r)")
        gradients = frozen_array("gradients", self.gradients, (points, 9, r))
        counts = tuple(int(count) for count in self.counts)
        if len(self.laws) != len(counts) or min(counts, default=0) < 1 or sum(counts) != points:
            raise ValueError(f"{len(self.laws)} laws at {counts} points do not make {points}")
        if len(self.parameters) != len(self.laws):
            raise ValueError("each law needs its parameters")
        parameters = tuple(
            frozen_array("parameters", values, (len(law.names), count))
            for law, count, values in zip(self.laws, counts, self.parameters, strict=True)
        )
        if self.correction is not None:
            correction = symmetric_array("correction", self.correction)
            frozen_array("correction", correction, (r, r))
            object.__setattr__(self, "correction", correction)
        values = {"weights": weights, "gradients": gradients, "parameters": parameters}
        values |= {"counts": counts, "laws": tuple(self.laws)}
        for name, value in values.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_groups", tuple(self._grouped()))
        object.__setattr__(self, "_level", 0.0)
        object.__setattr__(self, "_level", float(self._energies(np.zeros((1, r)))[0]))

    def _grouped(self) -> Sequence[PointGroup]:
        ends = np.cumsum(self.counts).tolist()
        return [
            PointGroup.of(
                law, values, self.gradients[end - count : end], self.weights[end - count : end]
            )
            for law, values, count, end in zip(
                self.laws, self.parameters, self.counts, ends, strict=True
            )
        ]

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return int(self.gradients.shape[2])

    @property
    def points(self) -> int:
        """Number of points p."""
        return len(self.weights)

    def force(self, q: Array) -> Array:
        """Return f (..., r) at ``q`` (..., r)."""
        q = checked(q, self.size)
        if q.ndim == 1:
            return self.evaluator(q.shape).force(q).copy()
        return by_batches(q, (self.size,), self._most, lambda b: self.evaluator(b.shape).force(b))

    def stiffness(self, q: Array) -> Array:
        """Return K = df/dq (..., r, r), symmetric, at ``q`` (..., r)."""
        q = checked(q, self.size)
        if q.ndim == 1:
            return self.evaluator(q.shape).force_and_stiffness(q)[1].copy()
        tail = (self.size, self.size)
        return by_batches(
            q, tail, self._most, lambda b: self.evaluator(b.shape).force_and_stiffness(b)[1]
        )

    def energy(self, q: Array) -> Array:
        """Return W (...) [J], 0 at rest, at ``q`` (..., r)."""
        q = checked(q, self.size)
        if q.ndim == 1:
            return self._energies(q[None])[0]
        return by_batches(q, (), self._most, self._energies)

    def _energies(self, q: Array) -> Array:
        total = np.full(len(q), -self._level)
        if self.correction is not None:
            total += 0.5 * np.vecdot(q, q @ self.correction)
        for group in self._groups:
            total += group.energies(q)
        return total

    def deformations(self, q: Array) -> Array:
        """Return the deformation gradients F (..., p, 3, 3) at the points."""
        q = checked(q, self.size)
        moved = np.tensordot(q, self.gradients, axes=(-1, 2)) + IDENTITY
        return moved.reshape(*q.shape[:-1], self.points, 3, 3)

    def strains(self, q: Array) -> Array:
        """Return the size of Green's strain ‖Fᵀ F − I‖ / 2 (..., p) [-] at the points."""
        F = self.deformations(q)
        C = np.matmul(np.swapaxes(F, -1, -2), F) - np.eye(3)
        return 0.5 * np.sqrt(np.einsum("...ij,...ij->...", C, C))

    @property
    def _most(self) -> int:
        """Bodies of one batch."""
        return max(1, _BUFFER // self.gradients.size)

    def evaluator(self, shape: tuple[int, ...]) -> CubatureEvaluator | CubatureBatchEvaluator:
        """Return the law with buffers for coordinates of ``shape``, (r,) or (b, r)."""
        if len(shape) == 1:
            return CubatureEvaluator(self._groups, self.correction)
        return CubatureBatchEvaluator(self._groups, self.correction, shape[0], self._most)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays that a model file holds of this law."""
        r = self.size
        correction = np.zeros((r, r)) if self.correction is None else self.correction
        return {
            "weights": self.weights,
            "gradients": self.gradients,
            "correction": correction,
            **pack_laws(self.laws, self.counts, self.parameters),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the law whose `arrays` these are.

        Raises:
            ValueError: they do not fit together.
            FileFormatError: a law in them is not known, or not fit to run.
        """
        correction = arrays["correction"]
        return cls(
            arrays["weights"],
            arrays["gradients"],
            *unpack_laws(arrays),
            correction if correction.any() else None,
        )
