"""The loops over quadrature points of ``native/strains.c``."""

import ctypes

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.loops import loops

Array = NDArray[np.float64]


def write_strain_columns(
    gradients: Array, shear: Array, spread: Array, out: Array, *, pairs: bool
) -> None:
    """Write shear · e + spread · tr(e) I of each field, e = sym D_i, and of each pair of fields.

    Args:
        gradients: D (r, 3, 3, p), [i, a, b] = ∂U_ia/∂X_b.
        shear: factors (p,).
        spread: factors (p,).
        out: (r, 6 p); with pairs (r + s, 6 p), s = r (r + 1)/2. A column has the numbers xx, yy,
            zz, √2 xy, √2 yz, √2 zx of all points, in the same order as the other columns.
        pairs: also of n_ij = sym(D_iᵀ D_j), i ≤ j in row-major order, after those of the fields.
    """
    r, p = gradients.shape[0], gradients.shape[-1]
    assert gradients.shape == (r, 3, 3, p)
    assert out.shape == (r + (r * (r + 1) // 2 if pairs else 0), 6 * p)
    arrays = (gradients, shear, spread, out)
    for array in arrays:
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
    loops("strains").fenics_defo_strain_columns(
        ctypes.c_int64(r),
        ctypes.c_int64(p),
        ctypes.c_int(pairs),
        *(ctypes.c_void_p(array.ctypes.data) for array in arrays),
    )
