"""Reduced Green strains at quadrature points as columns whose products are energies."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class StrainColumns:
    """Columns of the strains that r displacement fields and their pairs cause.

    With D_i = ∇U_i, the Green strain of u = Σ q_i U_i is

        E(q) = Σ_i q_i e_i + ½ Σ_ij q_i q_j n_ij,  e_i = sym D_i,  n_ij = sym(D_iᵀ D_j).

    Each point gives six rows: √w C^½ e in an orthonormal basis of symmetric tensors, with w its
    weight and C Hooke's isotropic tensor, so that the product of two columns, summed over points,
    is ∫ e : C : e' dX. In that basis C^½ e = √(2μ) e + (√(3λ + 2μ) - √(2μ))/3 tr(e) I.

    Args:
        size: number r of fields.
        points: largest number of points of one block.
        pairs: also give the columns n_ij, i ≤ j in row-major order, after the r of e_i.
    """

    def __init__(self, size: int, points: int, *, pairs: bool) -> None:
        self._size = size
        self.count = size + (size * (size + 1) // 2 if pairs else 0)
        self._pairs = pairs
        self._columns = np.empty(self.count * 6 * points)
        # Twice three rows of gradients: b and b + 1 of one field meet b + 1 and b of the other.
        self._rolled = np.empty(18 * size * points if pairs else 0)
        self._scaled = np.empty(18 * points if pairs else 0)

    def __call__(self, gradients: Array, weights: Array, lmbda: Array, mu: Array) -> Array:
        """The columns (count, 6, p) at p points, overwritten by the next call.

        Args:
            gradients: (r, 3, 3, p) [i, a, b] = ∂U_ia/∂X_b.
            weights: (p,) [m³].
            lmbda: λ (p,) [Pa].
            mu: μ (p,) [Pa].
        """
        points = len(weights)
        columns = self._columns[: self.count * 6 * points].reshape(self.count, 6, points)
        shear = np.sqrt(2.0 * mu * weights)
        dilation = (np.sqrt((3.0 * lmbda + 2.0 * mu) * weights) - shear) / 3.0
        ratio = dilation / shear
        self._write_linear(gradients, shear, ratio, columns[: self._size])
        if self._pairs:
            self._write_pairs(gradients, shear, ratio, columns[self._size :])
        return columns

    def _write_linear(self, gradients: Array, shear: Array, ratio: Array, out: Array) -> None:
        for row, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
            if a == b:
                np.multiply(gradients[:, a, a], shear, out=out[:, row])
            else:
                np.add(gradients[:, a, b], gradients[:, b, a], out=out[:, row])
                out[:, row] *= np.sqrt(0.5) * shear
        _add_trace(out, ratio)

    def _write_pairs(self, gradients: Array, shear: Array, ratio: Array, out: Array) -> None:
        points, begin = len(shear), 0
        rolled = self._rolled[: 18 * self._size * points].reshape(self._size, 6, 3, points)
        for b in range(3):
            rolled[:, :3, b] = gradients[:, :, (b + 1) % 3]
        rolled[:, 3:] = gradients
        scaled = self._scaled[: 18 * points].reshape(6, 3, points)
        for i in range(self._size):
            pairs = out[begin : begin + self._size - i]
            begin += self._size - i
            np.multiply(gradients[i], shear, out=scaled[:3])
            np.einsum("abp,jabp->jbp", scaled[:3], gradients[i:], out=pairs[:, :3])
            scaled[:3] *= np.sqrt(0.5)
            np.multiply(rolled[i, :3], np.sqrt(0.5) * shear, out=scaled[3:])
            np.einsum("cbp,jcbp->jbp", scaled, rolled[i:], out=pairs[:, 3:])
            _add_trace(pairs, ratio)  # now, while they are in the cache


def _add_trace(columns: Array, ratio: Array) -> None:
    """Add to the first three rows of (k, 6, p) their sum times ``ratio`` (p,)."""
    trace = columns[:, 0] + columns[:, 1]
    trace += columns[:, 2]
    trace *= ratio
    columns[:, :3] += trace[:, None]
