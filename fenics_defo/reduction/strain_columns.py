"""Reduced Green strains at quadrature points as columns whose products are energies."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.strain_kernels import write_strain_columns

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
        self._pairs = pairs
        self.count = size + (size * (size + 1) // 2 if pairs else 0)
        self._columns = np.empty(self.count * 6 * points)

    def __call__(self, gradients: Array, weights: Array, lmbda: Array, mu: Array) -> Array:
        """The columns (count, 6 p) at p points, overwritten by the next call.

        Args:
            gradients: (r, 3, 3, p) [i, a, b] = ∂U_ia/∂X_b.
            weights: (p,) [m³].
            lmbda: λ (p,) [Pa].
            mu: μ (p,) [Pa].
        """
        points = len(weights)
        columns = self._columns[: self.count * 6 * points].reshape(self.count, 6 * points)
        shear = np.sqrt(2.0 * mu * weights)
        spread = (np.sqrt((3.0 * lmbda + 2.0 * mu) * weights) - shear) / 3.0
        write_strain_columns(gradients, shear, spread, columns, pairs=self._pairs)
        return columns
