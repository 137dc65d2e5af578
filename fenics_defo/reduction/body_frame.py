"""Displacements of a flying body as seen from the body itself."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def in_body_frame(points: Array, mass: Array, displacements: Array) -> Array:
    """Take the rigid motion out of displacements, however large it is.

    Of all rigid motions that which comes closest to each deformed shape is undone: with the
    rotation R that minimises Σ m |x + u - c - R (x - c₀)|², the rest is Rᵀ(x + u - c) - (x - c₀).
    It has no momentum of the first order, Σ m u = 0 and Σ m x × u = 0. Source: Kabsch, A solution
    for the best rotation to relate two sets of vectors, Acta Crystallographica A 32, 1976.

    Args:
        points: x, nodes at rest (n, 3) [m].
        mass: m (n,) [kg], not negative.
        displacements: u (s, n, 3) [m].

    Returns:
        (s, n, 3) [m].
    """
    share = mass / mass.sum()
    rest = points - share @ points
    deformed = points + displacements
    deformed = deformed - np.einsum("n,snc->sc", share, deformed)[:, None]
    U, _, V = np.linalg.svd(np.einsum("n,snc,nd->scd", share, deformed, rest))
    U[:, :, 2] *= np.linalg.det(U @ V)[:, None]  # a rotation, no reflection
    return np.asarray(deformed @ (U @ V) - rest)
