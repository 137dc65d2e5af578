"""Isotropic energies of the invariants at a batch of points, from a list of operations."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.operations import Machine, OperationList

type Array = NDArray[np.float64]

# Component 3 i + a of A × B is A[p] B[q] + A[q] B[p] − A[r] B[s] − A[s] B[r], with i, j, k and
# a, b, c cyclic.
_TURN = [(i, (i + 1) % 3, (i + 2) % 3) for i in range(3)]
_MINORS = np.array(
    [(3 * j + b, 3 * k + c, 3 * j + c, 3 * k + b) for i, j, k in _TURN for a, b, c in _TURN]
).T


def _cross_table() -> Array:
    """A table (9, 81): a gradient's row times it is the matrix (9, 9) of X -> F × X."""
    epsilon = np.zeros((3, 3, 3))
    for i, j, k in _TURN:
        epsilon[i, j, k], epsilon[i, k, j] = 1.0, -1.0
    return np.einsum("ikm,jln->mnijkl", epsilon, epsilon).reshape(9, 81)


_CROSS = _cross_table()
_CROSS_AND_EYE = np.concatenate([_CROSS, np.eye(9).reshape(1, 81)])
_SECOND = {
    (a, b): 4 + k for k, (a, b) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)])
}


class IsotropicKernel:
    """ψ(I1, I2, J) at n points; see `PointKernel`.

    With H = cof F = ½ F × F and the symmetric product (A × B)_ia = ε_ijk ε_abc A_jb B_kc, the
    invariants are I1 = F : F, I2 = H : H and J = F : H / 3; with ψ₁, ψ₂, ψ_J the derivatives of ψ,

        P = 2 ψ₁ F + 2 ψ₂ F × H + ψ_J H,
        ∂P/∂F = Σ_ab ψ_ab z_a ⊗ z_b + 2 ψ₁ I + 2 ψ₂ (F×)(F×) + (ψ_J F + 2 ψ₂ H)×,

    where z₁ = 2 F, z₂ = 2 F × H, z_J = H and X× is the matrix of the product with X. What a law
    does not depend on is left out.

    Args:
        listing: of three invariants and the parameters; gives ψ, ψ₁, ψ₂, ψ_J, and ψ₁₁, ψ₁₂, ψ₁_J,
            ψ₂₂, ψ₂_J, ψ_JJ.
        parameters: (n,) or a number for each further input.
        count: number of points n.

    Source: Bonet, Gil and Ortigosa, A computational framework for polyconvex large strain
    elasticity, Computer Methods in Applied Mechanics and Engineering 283 (2015).
    """

    def __init__(
        self, listing: OperationList, parameters: Sequence[Array | float], count: int
    ) -> None:
        self.gradients: Array = np.zeros((9, count))
        self._listing, self._parameters = listing, dict(enumerate(parameters, start=3))
        idle = listing.idle_outputs()
        self._uses_I2 = not idle[2]
        self._second = {pair: row for pair, row in _SECOND.items() if not idle[row]}
        self._active = sorted({a for pair in self._second for a in pair})
        self._invariants = np.zeros((3, count))
        self._minors, self._products = np.zeros((4, 9, count)), np.zeros((9, count))
        self._cofactor, self._stress, self._z2 = np.zeros((3, 9, count))
        self._factor = np.zeros(count)
        self._features = np.zeros((10, count))
        self._tangent, self._added = np.zeros((2, count, 9, 9))
        self._slopes, self._bent = np.zeros((2, count, len(self._active), 9))

    def energy(self) -> Array:
        """ψ (n,) [J/m³]."""
        self._measure()
        return self._level.run()[0]

    def stress(self) -> Array:
        """P (9, n) [Pa]."""
        self._measure()
        return self._stresses(self._sloped.run())

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa]."""
        self._measure()
        outputs = self._curved.run()
        return self._stresses(outputs), self._tangents(outputs)

    @cached_property
    def _level(self) -> Machine:
        return self._machine(range(1))

    @cached_property
    def _sloped(self) -> Machine:
        return self._machine(range(1, 4))

    @cached_property
    def _curved(self) -> Machine:
        return self._machine(range(1, 10))

    def _machine(self, outputs: range) -> Machine:
        """What computes some outputs of the list from the invariants."""
        listing, shape = self._listing.only(outputs), self._factor.shape
        return Machine(listing, shape, self._parameters, inputs=self._invariants)

    def _measure(self) -> None:
        """H and the invariants of the gradients."""
        F, H, invariants = self.gradients, self._cofactor, self._invariants
        p, q, r, s = np.take(F, _MINORS, axis=0, out=self._minors, mode="clip")
        np.multiply(p, q, out=H)
        np.multiply(r, s, out=self._products)
        np.subtract(H, self._products, out=H)
        np.vecdot(F.T, F.T, out=invariants[0])
        np.vecdot(F[:3].T, H[:3].T, out=invariants[2])
        if self._uses_I2:
            np.vecdot(H.T, H.T, out=invariants[1])

    def _stresses(self, slopes: Array) -> Array:
        """P of ψ₁, ψ₂, ψ_J, the first rows of ``slopes``; F × H is kept in z₂ / 2."""
        F, H, scratch, stress = self.gradients, self._cofactor, self._products, self._stress
        np.multiply(F, np.multiply(slopes[0], 2.0, out=self._factor), out=stress)
        stress += np.multiply(H, slopes[2], out=scratch)
        if self._uses_I2:
            self._cross()
            stress += np.multiply(self._z2, slopes[1], out=scratch)
        return stress

    def _cross(self) -> None:
        """z₂ = 2 F × H from the minors of F, which are overwritten."""
        of_F = self._minors
        for row, partner in enumerate((1, 0, 3, 2)):  # p and q, q and p, r and s, s and r
            of_H = self._products
            np.take(self._cofactor, _MINORS[partner], axis=0, out=of_H, mode="clip")
            of_F[row] *= of_H
        np.add(of_F[0], of_F[1], out=self._z2)
        self._z2 -= of_F[2]
        self._z2 -= of_F[3]
        self._z2 *= 2.0

    def _tangents(self, outputs: Array) -> Array:
        """∂P/∂F of ψ₁, ψ₂, ψ_J and the second derivatives, after `_stresses` of the same."""
        tangent, added, features = self._tangent, self._added, self._features
        flat = tangent.reshape(-1, 81)
        np.multiply(self.gradients, outputs[2], out=features[:9])
        features[9] = self._factor
        if self._uses_I2:
            twice = np.multiply(outputs[1], 2.0, out=self._factor)
            features[:9] += np.multiply(self._cofactor, twice, out=self._products)
            np.dot(self.gradients.T, _CROSS, out=flat)
            np.multiply(tangent, twice[:, None, None], out=added)
            squared = np.matmul(added, tangent)
            np.dot(features.T, _CROSS_AND_EYE, out=flat)
            tangent += squared
        else:
            np.dot(features.T, _CROSS_AND_EYE, out=flat)
        if self._active:
            self._bend(outputs)
            tangent += np.einsum("nki,nkj->nij", self._slopes, self._bent, out=added)
        return tangent

    def _bend(self, outputs: Array) -> None:
        """z_a and Σ_b ψ_ab z_b for each invariant that the second derivatives name."""
        z = {1: self._z2, 2: self._cofactor}
        if 0 in self._active:
            z[0] = np.multiply(self.gradients, 2.0, out=self._minors[0])
        for place, a in enumerate(self._active):
            self._slopes[:, place] = z[a].T
            total = self._minors[1]
            total[:] = 0.0
            for b in self._active:
                row = self._second.get((min(a, b), max(a, b)))
                if row is not None:
                    total += np.multiply(z[b], outputs[row - 1], out=self._products)
            self._bent[:, place] = total.T
