"""Corotational elasticity at batches of points: Hooke's law in the frame that turns with F."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.polar import polar_rotation
from fenics_defo.runtime.laws.response import PointResponse

type Array = NDArray[np.float64]
type Tangent = Literal["exact", "definite", "approximate"]


def corotational(
    F: Array,
    mu: Array | float,
    lmbda: Array | float,
    *,
    tangent: Tangent | None = "exact",
    out: PointResponse | None = None,
) -> PointResponse:
    """ψ = μ |F − R|² + λ/2 tr(Rᵀ F − I)² with R the proper rotation nearest to F.

    Args:
        F: deformation gradients (m, 3, 3) [-].
        mu: shear modulus μ [Pa], a number or (m,).
        lmbda: Lamé's first constant λ [Pa], a number or (m,).
        tangent: "exact", ∂P/∂F; "definite", the same without its negative eigenvalues;
            "approximate", Hooke's tensor turned by R; None for none.
        out: arrays to write into.

    Returns:
        the response at the m points.
    """
    out = out or PointResponse.empty(len(F), tangent=tangent is not None)
    mu, lmbda = np.broadcast_to(mu, len(F)), np.broadcast_to(lmbda, len(F))
    R = polar_rotation(F)
    stretch = np.einsum("mij,mij->m", R, F - R)
    out.energy[:] = mu * np.einsum("mij,mij->m", F - R, F - R) + lmbda / 2 * stretch**2
    out.stress[:] = (
        2 * mu[:, None, None] * (F - R) + lmbda[:, None, None] * stretch[:, None, None] * R
    )
    if tangent is None or out.tangent is None:
        return out
    one = np.eye(3)
    S = np.einsum("mki,mkj->mij", R, F)
    weights = mu[:, None, None] * -one
    if tangent != "approximate":
        G = np.trace(S, axis1=1, axis2=2)[:, None, None] * one - (S + S.transpose(0, 2, 1)) / 2
        weights = (lmbda * stretch - 2 * mu)[:, None, None] * np.linalg.inv(G)
    if tangent == "definite":
        values, vectors = np.linalg.eigh(weights + mu[:, None, None] * one)
        weights = np.einsum("mia,ma,mja->mij", vectors, np.maximum(values, 0), vectors)
        weights -= mu[:, None, None] * one
    levi = np.zeros((3, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        levi[i, j, k], levi[j, i, k] = 1, -1
    T = np.einsum("mik,kja->maij", R, -levi)
    out.tangent[:] = np.einsum("mab,maij,mbkl->mijkl", weights, T, T)
    out.tangent[:] += np.einsum("m,ik,jl->mijkl", 2 * mu, one, one)
    out.tangent[:] += np.einsum("m,mij,mkl->mijkl", lmbda, R, R)
    return out
