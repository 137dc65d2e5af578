"""Isotropic laws continued through inversion, at batches of points."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import batches, components, product, rows, transpose
from fenics_defo.runtime.laws.continuation import Derivatives, Parameter, continued
from fenics_defo.runtime.laws.principal_tangent import write_tangent
from fenics_defo.runtime.laws.response import PointResponse
from fenics_defo.runtime.laws.svd3 import svd_components

type Array = NDArray[np.float64]


def invertible(
    F: Array,
    derivatives: Derivatives,
    parameters: tuple[Parameter, ...] = (),
    *,
    threshold: float = 0.1,
    tangent: bool = True,
    definite: bool = True,
    out: PointResponse | None = None,
) -> PointResponse:
    """An isotropic law of the signed principal stretches, continued below a threshold.

    F = U diag(s) Vᵀ with proper rotations, so that the smallest stretch is negative where the point
    is inside out; ψ(F) = ψ̃(s), P = U diag(∂ψ̃/∂s) Vᵀ. Above the threshold ψ̃ is the law; below,
    `continued` says what it is. Stress and tangent are derivatives of the energy everywhere but
    where s2 + s3 = 0: there ψ is continuous and has a ridge, as the rotation jumps.

    Args:
        F: deformation gradients (m, 3, 3) [-].
        derivatives: takes principal stretches (b, 3), each at least ``threshold``, and each of
            ``parameters`` for these points; returns ψ (b,), ∂ψ/∂s (b, 3) and ∂²ψ/∂s² (b, 3, 3)
            [Pa], symmetric in the stretches. The stretches are a view whose columns are contiguous,
            and it is best if the answers are such views too.
        parameters: numbers, or (m,) one a point.
        threshold: stretch below which the law is continued, between 0 and 1 [-].
        tangent: whether the tangent is wanted.
        definite: raise the negative eigenvalues of the tangent at each point to zero.
        out: arrays to write into; fresh ones otherwise.

    Returns:
        the response at the m points, which is ``out`` if that was given.

    References: Irving, Teran and Fedkiw, Invertible finite elements for robust simulation of large
    deformation, 2004; Teran et al., Robust quasistatic finite elements and flesh simulation, 2005;
    Stomakhin et al., Energetically consistent invertible elasticity, 2012.
    """
    if out is None:
        out = PointResponse.empty(len(F), tangent=tangent)
    for part in batches(len(F)):
        own = tuple(rows(value, part) for value in parameters)
        U, s, V = svd_components(components(F[part]))
        state = continued(s, derivatives, own, threshold=threshold, curvature=tangent)
        out.energy[part] = state.energy
        out.stress[part] = product(U * state.stress, transpose(V)).transpose(2, 0, 1)
        if tangent:
            assert out.tangent is not None
            write_tangent(out.tangent[part], U, s, V, state, definite=definite)
    return out
