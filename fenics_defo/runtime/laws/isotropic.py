"""Isotropic energies of the invariants at a batch of points, from a list of operations."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.operations import Machine, OperationList

type Array = NDArray[np.float64]

# Cofactor of component 3 i + a is F[p] F[q] − F[r] F[s], with i, j, k and a, b, c cyclic.
_TURN = [(i, (i + 1) % 3, (i + 2) % 3) for i in range(3)]
_MINORS = np.array(
    [(3 * j + b, 3 * k + c, 3 * j + c, 3 * k + b) for i, j, k in _TURN for a, b, c in _TURN]
).T


def _second_of_determinant() -> Array:
    """∂²J / ∂F_ij ∂F_kl = ε_ikm ε_jln F_mn as a table (9, 81): the products with F (9,)."""
    epsilon = np.zeros((3, 3, 3))
    for i, j, k in _TURN:
        epsilon[i, j, k], epsilon[i, k, j] = 1.0, -1.0
    return np.einsum("ikm,jln->mnijkl", epsilon, epsilon).reshape(9, 81)


_DETERMINANT = _second_of_determinant()
_EYE = np.eye(9).reshape(81)
_SECOND = {
    (a, b): 4 + k for k, (a, b) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)])
}


class IsotropicKernel:
    """ψ(I1, I2, J) at n points; see `PointKernel`.

        P = 2 (ψ₁ + ψ₂ I1) F − 2 ψ₂ F C + ψ_J cof F,    C = Fᵀ F, cof F = ∂J/∂F,

    with ψ₁, ψ₂, ψ_J the derivatives of ψ by I1 = tr C, I2 = ((tr C)² − tr C²)/2 and J = det F. The
    tangent has the second derivatives of ψ between z₁ = 2 F, z₂ = 2 (I1 F − F C), z_J = cof F, and
    the first ones times those of the invariants:

        ∂P/∂F = Σ_ab ψ_ab z_a ⊗ z_b + 2 ψ₁ I + ψ₂ ∂²I2/∂F² + ψ_J ∂²J/∂F².

    What a law does not depend on is left out.

    Args:
        listing: of three invariants and the parameters; gives ψ, ψ₁, ψ₂, ψ_J, and ψ₁₁, ψ₁₂, ψ₁_J,
            ψ₂₂, ψ₂_J, ψ_JJ.
        parameters: (n,) or a number for each further input.
        count: number of points n.

    Source: Bonet and Wood, Nonlinear Continuum Mechanics (2008), section 6.3.
    """

    def __init__(
        self, listing: OperationList, parameters: Sequence[Array | float], count: int
    ) -> None:
        self.gradients: Array = np.zeros((9, count))
        self._machine = Machine(listing, (count,), dict(enumerate(parameters, start=3)))
        idle = listing.idle_outputs()
        self._uses_I2 = not idle[2]
        self._second = {pair: row for pair, row in _SECOND.items() if not idle[row]}
        self._active = sorted({a for pair in self._second for a in pair})
        size = (9, count)
        self._cofactor, self._stress, self._scratch = (np.zeros(size) for _ in range(3))
        self._parts = np.zeros((4, *size))
        self._FC = np.zeros(size)
        self._C = np.zeros((3, 3, count))
        self._slopes = np.zeros((count, len(self._active), 9))
        self._bent = np.zeros((count, len(self._active), 9))
        self._tangent = np.zeros((count, 81))
        self._added = np.zeros((count, 81))
        self._factor = np.zeros(count)

    def energy(self) -> Array:
        """ψ (n,) [J/m³]."""
        return self._respond()[0]

    def stress(self) -> Array:
        """P (9, n) [Pa]."""
        return self._stresses(self._respond())

    def stress_and_tangent(self) -> tuple[Array, Array]:
        """P (9, n) and ∂P/∂F (n, 9, 9) [Pa]."""
        outputs = self._respond()
        stress = self._stresses(outputs)
        count = self.gradients.shape[1]
        tangent = self._tangent.reshape(count, 9, 9)
        if self._active:
            self._bend(outputs)
            np.matmul(self._slopes.transpose(0, 2, 1), self._bent, out=tangent)
        else:
            tangent[:] = 0.0
        np.multiply(self.gradients, outputs[3], out=self._scratch)
        np.dot(self._scratch.T, _DETERMINANT, out=self._added)
        self._tangent += self._added
        np.multiply(outputs[1], 2.0, out=self._factor)
        if self._uses_I2:
            self._add_second_invariant(tangent, outputs[2])
        self._tangent[:, ::10] += self._factor[:, None]
        return stress, tangent

    def _respond(self) -> Array:
        """Outputs of the list at the invariants of the gradients."""
        F, inputs = self.gradients, self._machine.inputs
        p, q, r, s = self._parts
        for place, rows in zip((p, q, r, s), _MINORS, strict=True):
            np.take(F, rows, axis=0, out=place, mode="clip")
        np.multiply(p, q, out=self._cofactor)
        np.multiply(r, s, out=p)
        self._cofactor -= p
        np.einsum("cn,cn->n", F, F, out=inputs[0])
        np.einsum("cn,cn->n", F[:3], self._cofactor[:3], out=inputs[2])
        if self._uses_I2:
            X = F.reshape(3, 3, -1)
            np.einsum("kan,kbn->abn", X, X, out=self._C)
            np.einsum("abn,abn->n", self._C, self._C, out=inputs[1])
            np.multiply(inputs[0], inputs[0], out=self._factor)
            np.subtract(self._factor, inputs[1], out=inputs[1])
            inputs[1] *= 0.5
        return self._machine.run()

    def _stresses(self, outputs: Array) -> Array:
        stress, scratch = self._stress, self._scratch
        np.multiply(outputs[1], 2.0, out=self._factor)
        if self._uses_I2:
            X, FC = self.gradients.reshape(3, 3, -1), self._FC.reshape(3, 3, -1)
            np.einsum("kan,abn->kbn", X, self._C, out=FC)
            z = self._parts[0]
            np.multiply(self.gradients, self._machine.inputs[0], out=z)
            z -= self._FC
            z *= 2.0  # ∂I2/∂F
            np.multiply(self.gradients, self._factor, out=stress)
            np.multiply(z, outputs[2], out=scratch)
            stress += scratch
        else:
            np.multiply(self.gradients, self._factor, out=stress)
        np.multiply(self._cofactor, outputs[3], out=scratch)
        stress += scratch
        return stress

    def _bend(self, outputs: Array) -> None:
        """z_a and Σ_b ψ_ab z_b for each invariant that the second derivatives name."""
        z = {2: self._cofactor}
        if 1 in self._active:
            z[1] = self._parts[0]
        if 0 in self._active:
            z[0] = np.multiply(self.gradients, 2.0, out=self._parts[1])
        for row, a in enumerate(self._active):
            self._slopes[:, row] = z[a].T
            total = self._parts[2]
            total[:] = 0.0
            for b in self._active:
                output = self._second.get((min(a, b), max(a, b)))
                if output is not None:
                    total += np.multiply(z[b], outputs[output], out=self._scratch)
            self._bent[:, row] = total.T

    def _add_second_invariant(self, tangent: Array, slope: Array) -> None:
        """ψ₂ ∂²I2/∂F²: 4 F_ij F_kl + 2 I1 δ_ik δ_jl − 2 (δ_ik C_jl + F_il F_kj + B_ik δ_jl)."""
        count = len(slope)
        X = self.gradients.reshape(3, 3, -1)
        twice = np.multiply(slope, 2.0)
        F = self.gradients.T
        scaled = F * twice[:, None]
        outer = scaled[:, :, None] * F[:, None, :]
        blocks = tangent.reshape(count, 3, 3, 3, 3)
        tangent += 2.0 * outer
        blocks -= outer.reshape(count, 3, 3, 3, 3).transpose(0, 1, 4, 3, 2)
        C = np.multiply(self._C, twice).transpose(2, 0, 1)
        B = np.multiply(np.einsum("ian,kan->ikn", X, X), twice).transpose(2, 0, 1)
        for i in range(3):
            blocks[:, i, :, i, :] -= C
            blocks[:, :, i, :, i] -= B
        self._factor += twice * self._machine.inputs[0]
