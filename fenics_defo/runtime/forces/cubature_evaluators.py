"""The loop's side of cubature: buffers made once, few calls of NumPy, products by BLAS."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws import MaterialLaw, PointKernel
from fenics_defo.runtime.laws.kernel import IDENTITY

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PointGroup:
    """The n points of one law, laid out for products.

    Args:
        law: theirs.
        parameters: (names, n).
        weights: (n,).
        rows: G (9 n, r), component by component, points innermost.
        weighted: the same times the weights.
        blocks: G (n, 9, r).
        weighted_blocks: w G (9 n, r), point by point.
    """

    law: MaterialLaw
    parameters: Array
    weights: Array
    rows: Array
    weighted: Array
    blocks: Array
    weighted_blocks: Array

    @classmethod
    def of(
        cls, law: MaterialLaw, parameters: Array, gradients: Array, weights: Array
    ) -> "PointGroup":
        """The group of points with gradients (n, 9, r) and weights (n,)."""
        r = gradients.shape[2]
        scaled = gradients * weights[:, None, None]
        return cls(
            law=law,
            parameters=parameters,
            weights=weights,
            rows=np.ascontiguousarray(gradients.transpose(1, 0, 2)).reshape(-1, r),
            weighted=np.ascontiguousarray(scaled.transpose(1, 0, 2)).reshape(-1, r),
            blocks=np.ascontiguousarray(gradients),
            weighted_blocks=scaled.reshape(-1, r),
        )

    def kernel(self, bodies: int = 1) -> PointKernel:
        """The law at the points of some bodies; a point's bodies lie beside each other."""
        values = [np.repeat(row, bodies) for row in self.parameters]
        return self.law.kernel(values, len(self.weights) * bodies)

    def energies(self, q: Array) -> Array:
        """Σ w ψ (b,) at coordinates (b, r)."""
        kernel = self.kernel(len(q))
        with np.errstate(all="ignore"):
            np.dot(self.rows, q.T, out=kernel.gradients.reshape(len(self.rows), len(q)))
            kernel.gradients += IDENTITY[:, None]
            return self.weights @ kernel.energy().reshape(len(self.weights), len(q))


class CubatureEvaluator:
    """Evaluator of one body; see `fenics_defo.runtime.forces.force_law.Evaluator`."""

    def __init__(self, groups: Sequence[PointGroup], correction: Array | None) -> None:
        self._correction = correction
        self._parts = []
        for group in groups:
            kernel, n, r = group.kernel(), *group.blocks.shape[::2]
            places = kernel.gradients.reshape(-1), np.empty((n, 9, r))
            self._parts.append((group, kernel, *places, places[1].reshape(-1, r)))
        self._identity = IDENTITY[:, None]
        self._force, self._share = np.empty(r), np.empty(r)
        self._half, self._stiffness = np.empty((r, r)), np.empty((r, r))

    def force(self, q: Array) -> Array:
        """Return f (r,) at ``q`` (r,), overwritten by the next call."""
        force = self._started(q)
        with np.errstate(all="ignore"):
            for group, kernel, flat, _, _ in self._parts:
                np.dot(group.rows, q, out=flat)
                kernel.gradients += self._identity
                np.dot(kernel.stress().reshape(-1), group.weighted, out=self._share)
                force += self._share
        return force

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f as `force` does, and K (r, r) at ``q``."""
        force, half, whole = self._started(q), self._half, self._stiffness
        with np.errstate(all="ignore"):
            for number, (group, kernel, flat, product, rows) in enumerate(self._parts):
                np.dot(group.rows, q, out=flat)
                kernel.gradients += self._identity
                stress, tangent = kernel.stress_and_tangent()
                np.dot(stress.reshape(-1), group.weighted, out=self._share)
                force += self._share
                np.matmul(tangent, group.blocks, out=product)
                if number == 0:
                    np.dot(group.weighted_blocks.T, rows, out=half)
                else:
                    half += np.dot(group.weighted_blocks.T, rows, out=whole)
            np.add(half, half.T, out=whole)  # symmetric to the last digit
            whole *= 0.5
            if self._correction is not None:
                whole += self._correction
        return force, whole

    def _started(self, q: Array) -> Array:
        if self._correction is None:
            self._force[:] = 0.0
            return self._force
        return np.dot(self._correction, q, out=self._force)


class CubatureBatchEvaluator:
    """Evaluator of b bodies, a few at a time, so that what they need stays in the cache."""

    def __init__(
        self, groups: Sequence[PointGroup], correction: Array | None, bodies: int, most: int
    ) -> None:
        r = groups[0].blocks.shape[2]
        self._correction = correction
        self._slices = [slice(begin, min(begin + most, bodies)) for begin in range(0, bodies, most)]
        widths = sorted({part.stop - part.start for part in self._slices})
        self._kernels = {b: [(group, group.kernel(b)) for group in groups] for b in widths}
        largest = max((len(group.weights) for group in groups), default=1)
        self._products = np.empty(max(widths, default=1) * largest * 9 * r)
        self._force = np.empty((bodies, r))
        self._stiffness = np.empty((bodies, r, r))

    def force(self, q: Array) -> Array:
        """Return f (b, r) at ``q`` (b, r), overwritten by the next call."""
        self._start(q)
        with np.errstate(all="ignore"):
            for part in self._slices:
                for group, kernel in self._kernels[part.stop - part.start]:
                    _deform(group, kernel, q[part])
                    self._add_force(group, kernel.stress(), part)
        return self._force

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        """Return f as `force` does, and K (b, r, r) at ``q``."""
        self._start(q)
        self._stiffness[:] = 0.0 if self._correction is None else self._correction
        with np.errstate(all="ignore"):
            for part in self._slices:
                for group, kernel in self._kernels[part.stop - part.start]:
                    _deform(group, kernel, q[part])
                    stress, tangent = kernel.stress_and_tangent()
                    self._add_force(group, stress, part)
                    self._add_stiffness(group, tangent, part)
        return self._force, self._stiffness

    def _start(self, q: Array) -> None:
        if self._correction is None:
            self._force[:] = 0.0
        else:
            np.dot(q, self._correction, out=self._force)

    def _add_force(self, group: PointGroup, stress: Array, part: slice) -> None:
        bodies = part.stop - part.start
        self._force[part] += np.dot(stress.reshape(-1, bodies).T, group.weighted)

    def _add_stiffness(self, group: PointGroup, tangent: Array, part: slice) -> None:
        bodies, (n, _, r) = part.stop - part.start, group.blocks.shape
        product = self._products[: bodies * n * 9 * r].reshape(bodies, n, 9, r)
        of_bodies = tangent.reshape(n, bodies, 9, 9).transpose(1, 0, 2, 3)
        np.matmul(of_bodies, group.blocks, out=product)
        half = np.matmul(group.weighted_blocks.T, product.reshape(bodies, 9 * n, r))
        half *= 0.5
        self._stiffness[part] += half
        self._stiffness[part] += half.transpose(0, 2, 1)


def _deform(group: PointGroup, kernel: PointKernel, q: Array) -> None:
    """Set the kernel's gradients to F = I + G q of bodies (b, r)."""
    np.dot(group.rows, q.T, out=kernel.gradients.reshape(len(group.rows), len(q)))
    kernel.gradients += IDENTITY[:, None]
