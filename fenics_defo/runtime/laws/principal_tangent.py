"""The tangent of an isotropic law from its derivatives in the principal stretches."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.laws.batches import combined, store_block, transpose
from fenics_defo.runtime.laws.continuation import PrincipalState
from fenics_defo.runtime.laws.eigen3 import raise_to_zero

type Array = NDArray[np.float64]

_PAIRS = ((0, 1), (0, 2), (1, 2))
# Stretches that differ by less, relative to the largest, count as equal: a difference quotient of
# the stresses would lose more than the mean of the curvatures does (its error is the square).
_EQUAL = 1e-5
# Least sum of two stretches: at zero the rotation between them jumps, and their twist is infinite.
_OPPOSITE = 1e-8


def write_tangent(
    out: Array, U: Array, s: Array, V: Array, state: PrincipalState, *, definite: bool
) -> None:
    """Write ∂P_ij/∂F_kl (b, 3, 3, 3, 3) of P = U diag(g) Vᵀ, g = ∂ψ/∂s.

    In the principal axes the derivative couples the diagonal entries by H = ∂²ψ/∂s², and for each
    pair p < q the entries pq and qp by the symmetric matrix [[α, β], [β, α]], whose eigenvalues are

        α + β = (g_p − g_q)/(s_p − s_q)   (flip: the symmetric part of the entries)
        α − β = (g_p + g_q)/(s_p + s_q)   (twist: the antisymmetric part).

    Args:
        out: where to write.
        U: left singular vectors (3, 3, b).
        s: signed stretches (3, b), s1 ≥ s2 ≥ |s3|.
        V: right singular vectors (3, 3, b).
        state: the law at ``s``.
        definite: raise the negative eigenvalues of H and of the pairs to zero.

    References: Teran et al., Robust quasistatic finite elements and flesh simulation, 2005; Smith
    et al., Analytic eigensystems for isotropic distortion energies, 2019.
    """
    assert state.curvature is not None
    g, H = state.stress, state.curvature
    alphas, betas = {}, {}
    for p, q in _PAIRS:
        gap = s[p] - s[q]
        equal = gap <= _EQUAL * s[0]
        flip = np.where(
            equal, 0.5 * (H[p, p] + H[q, q]) - H[p, q], (g[p] - g[q]) / np.where(equal, 1.0, gap)
        )
        twist = (g[p] + g[q]) / np.maximum(s[p] + s[q], _OPPOSITE)
        if definite:
            flip, twist = np.maximum(flip, 0.0), np.maximum(twist, 0.0)
        alphas[p, q] = 0.5 * (flip + twist)
        betas[p, q] = 0.5 * (flip - twist)
    if definite:
        H = raise_to_zero(H)
    _write(out, U, _couplings(V, H, alphas, betas))


def _couplings(
    V: Array,
    H: Array,
    alphas: dict[tuple[int, int], Array],
    betas: dict[tuple[int, int], Array],
) -> dict[tuple[int, int], Array]:
    """M^pr (3, 3, b), p ≤ r, of A_ijkl = Σ_pr U_ip U_kr (M^pr)_jl; M^rp is the transpose."""
    v = [V[:, p] for p in range(3)]
    squares = [x[:, None] * x for x in v]
    term = np.empty_like(V)
    result = {}
    for p, r in _PAIRS:
        both = v[p][:, None] * v[r]
        result[p, r] = np.empty_like(V)
        combined([both, transpose(both)], [H[p, r], betas[p, r]], result[p, r], term)
    for p in range(3):
        weights = [H[p, p] if q == p else alphas[min(p, q), max(p, q)] for q in range(3)]
        result[p, p] = np.empty_like(V)
        combined(squares, weights, result[p, p], term)
    return result


def _write(out: Array, U: Array, M: dict[tuple[int, int], Array]) -> None:
    """A_ijkl = Σ_pr U_ip U_kr (M^pr)_jl, its half i ≤ k computed and the other copied."""
    columns = [[M[p, r] if p <= r else transpose(M[r, p]) for p in range(3)] for r in range(3)]
    rows, block, term = np.empty((3, *U.shape)), np.empty_like(U), np.empty_like(U)
    for i in range(3):
        for r in range(3):
            combined(columns[r], list(U[i]), rows[r], term)
        for k in range(i, 3):
            combined(list(rows), list(U[k]), block, term)
            store_block(out, block, i, k)
