"""The rotation in batches of 3 × 3 deformation gradients."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.svd3 import signed_svd

type Array = NDArray[np.float64]


def polar_rotation(F: Array) -> Array:
    """The proper rotation R nearest to F, which makes tr(Rᵀ F) largest.

    Args:
        F: (m, 3, 3); singular and inverted ones too.

    Returns:
        R (m, 3, 3), det R = 1.
    """
    U, _, V = signed_svd(F)
    return U @ V.transpose(0, 2, 1)
