"""Corotational elasticity at batches of points: Hooke's law in a frame that turns with F."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import (
    batches,
    cofactor,
    components,
    inner,
    product,
    rows,
    store_block,
    transpose,
)
from fenics_defo.runtime.laws.eigen3 import raise_to_zero
from fenics_defo.runtime.laws.polar import polar_components
from fenics_defo.runtime.laws.response import PointResponse

type Array = NDArray[np.float64]
type Tangent = Literal["exact", "definite", "approximate"]

# Smallest det G relative to (tr G)³: the derivative of the rotation is kept finite where the
# rotation jumps.
_SINGULAR = 1e-12
_TINY = 1e-100


def corotational(
    F: Array,
    mu: Array | float,
    lmbda: Array | float,
    *,
    tangent: Tangent | None = "exact",
    out: PointResponse | None = None,
) -> PointResponse:
    """ψ = μ |F − R|² + λ/2 tr(Rᵀ F − I)² with R the proper rotation nearest to F.

    P = 2μ (F − R) + λ tr(Rᵀ F − I) R. With S = Rᵀ F, G = tr(S) I − S and T_a = R [e_a]×, the
    derivative of the rotation is ∂R/∂F = T_a (G⁻¹)_ab T_b, so that all tangents have the form

        ∂P_ij/∂F_kl = 2μ δ_ik δ_jl + λ R_ij R_kl + W_ab (T_a)_ij (T_b)_kl

    exact:       W = (λ tr(S − I) − 2μ) G⁻¹, indefinite in compression;
    definite:    the same with the eigenvalues of W that are under −μ raised to −μ, which makes
                 those of the tangent that belong to T_a zero where they were negative;
    approximate: W = −μ I, Hooke's tensor turned by R (the warped stiffness of Müller and Gross,
                 Interactive virtual materials, 2004), equal to the exact one where F = R.

    R jumps where the sum of the two smaller signed stretches is zero (rank one, or inverted with
    |s3| = s2). There ψ is continuous and has a ridge, and the exact tangent is large and finite.

    Args:
        F: deformation gradients (m, 3, 3) [-].
        mu: shear modulus μ [Pa], a number or (m,).
        lmbda: Lamé's first constant λ [Pa], a number or (m,).
        tangent: which tangent, or None for none.
        out: arrays to write into; fresh ones otherwise.

    Returns:
        the response at the m points, which is ``out`` if that was given.

    References: Müller et al., Stable real-time deformations, 2002; Chao et al., A simple geometric
    model for elastic deformations, 2010 (the exact tangent).
    """
    if out is None:
        out = PointResponse.empty(len(F), tangent=tangent is not None)
    for part in batches(len(F)):
        _respond(out.part(part), components(F[part]), rows(mu, part), rows(lmbda, part), tangent)
    return out


def _respond(
    out: PointResponse, F: Array, mu: Array | float, lmbda: Array | float, tangent: Tangent | None
) -> None:
    """Write the response of one batch."""
    R = polar_components(F)
    strain = F - R
    dilation = inner(R, strain)  # tr(Rᵀ F − I), because R : R = 3
    pressure = lmbda * dilation
    out.energy[:] = mu * inner(strain, strain) + 0.5 * pressure * dilation
    out.stress[:] = (2.0 * mu * strain + pressure * R).transpose(2, 0, 1)
    if tangent is None:
        return
    assert out.tangent is not None
    if tangent == "approximate":
        weights = np.zeros_like(F)
        weights[np.arange(3), np.arange(3)] = -mu
    else:
        weights = _spin_weights(R, F, mu, pressure, definite=tangent == "definite")
    _write_tangent(out.tangent, R, weights, mu, lmbda)


def _spin_weights(
    R: Array, F: Array, mu: Array | float, pressure: Array, *, definite: bool
) -> Array:
    """W (3, 3, b), see `corotational`."""
    S = product(transpose(R), F)
    S += transpose(S.copy())
    S *= 0.5
    trace = S[0, 0] + S[1, 1] + S[2, 2]
    G, diagonal = -S, np.arange(3)
    G[diagonal, diagonal] += trace
    adjugate = cofactor(G)
    determinant = inner(G[0], adjugate[0])
    # NaN stays NaN: numpy.maximum keeps it.
    floor = _SINGULAR * (2.0 * trace) ** 3 + _TINY
    weights = adjugate * ((pressure - 2.0 * mu) / np.maximum(determinant, floor))
    if definite:
        weights[diagonal, diagonal] += mu
        weights = raise_to_zero(weights)
        weights[diagonal, diagonal] -= mu
    return weights


def _write_tangent(out: Array, R: Array, W: Array, mu: Array | float, lmbda: Array | float) -> None:
    """2μ δ_ik δ_jl + λ R_ij R_kl + W_ab (T_a)_ij (T_b)_kl; the rows of T are (r_i × e_a)_j."""
    scaled, term, block = lmbda * R, np.empty_like(R), np.empty_like(R)
    turned = np.empty_like(R)  # [r_i]× W
    for i in range(3):
        _write_crossed(turned, R[i], W, term)
        for k in range(i, 3):
            # Transposed, because (A [r]×ᵀ)ᵀ = [r]× Aᵀ.
            _write_crossed(transpose(block), R[k], transpose(turned), term)
            block += np.multiply(scaled[i, :, None], R[k], out=term)
            if i == k:
                for j in range(3):
                    block[j, j] += 2.0 * mu
            store_block(out, block, i, k)


def _write_crossed(out: Array, r: Array, A: Array, term: Array) -> None:
    """Write [r]× A into ``out``: each column of A after a cross product with r (3, b)."""
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(r[j], A[k], out=out[i])
        out[i] -= np.multiply(r[k], A[j], out=term[i])
