"""Isotropic laws continued through inversion, at batches of points."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.response import PointResponse
from fenics_defo.runtime.laws.svd3 import signed_svd

type Array = NDArray[np.float64]
type Derivatives = Callable[[Array], tuple[Array, Array, Array]]


def invertible(
    F: Array,
    derivatives: Derivatives,
    *,
    threshold: float = 0.1,
    definite: bool = True,
    tangent: bool = True,
    out: PointResponse | None = None,
) -> PointResponse:
    """An isotropic law of the signed principal stretches, continued below a threshold.

    Args:
        F: deformation gradients (m, 3, 3) [-].
        derivatives: takes principal stretches (m, 3), each at least ``threshold``; returns ψ (m,),
            ∂ψ/∂s (m, 3) and ∂²ψ/∂s² (m, 3, 3), symmetric in the stretches [Pa].
        threshold: stretch below which the law is continued, between 0 and 1.
        definite: raise the negative eigenvalues of the tangent at each point to zero.
        tangent: whether the tangent is wanted.
        out: arrays to write into.

    Returns:
        the response at the m points.
    """
    out = out or PointResponse.empty(len(F), tangent=tangent)
    U, s, V = signed_svd(F)
    clamped = np.maximum(s, threshold)
    d = s - clamped
    energy, slope, curvature = derivatives(clamped)
    k = 1.0
    free = d == 0
    out.energy[:] = energy + np.einsum("mi,mi->m", slope, d) + k / 2 * np.einsum("mi,mi->m", d, d)
    principal = slope + np.where(free, np.einsum("mij,mj->mi", curvature, d), k * d)
    out.stress[:] = np.einsum("mip,mp,mjp->mij", U, principal, V)
    if tangent and out.tangent is not None:
        out.tangent[:] = 0.0
        raise NotImplementedError
    return out
