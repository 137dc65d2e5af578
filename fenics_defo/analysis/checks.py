"""What vibration modes must stand: residuals, orthonormality; and the same vectors on each run."""

import logging

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.spectrum import align_clusters
from fenics_defo.errors import EigenSolveError

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

_RESIDUAL = 1e-6
# The residuals of exact eigenvectors were 1 to 12 times `_round_off`, on bars 100 to 1000
# times as long as thick, on springs, plates and blocks of both orders.
_ROUND_OFF = 30.0
_WORST_RESIDUAL = 1e-2
_ORTHONORMAL = 1e-8
# λ closer than this, or than a few times their residuals, are one eigenvalue, whose vectors may be
# rotated among each other.
_SAME = 1e-9


def checked_pairs(
    problem: EigenProblem,
    pairs: Pairs,
    *,
    fields: Array,
    floor: float,
    tolerance: float | None,
    cluster_rtol: float,
) -> tuple[Pairs, Array]:
    """Make the vectors unique and check them. Collective.

    Args:
        problem: the matrices.
        pairs: what a solver found.
        fields: (owned dofs, p) of norm about 1 in M, which align the vectors of equal λ.
        floor: what the residuals of motions without stiffness relate to [rad²/s²].
        tolerance: largest residual; None for 1e-6, or round-off if that is more.
        cluster_rtol: largest relative distance of λ that may be aligned.

    Returns:
        the pairs, and their relative residuals (k,) [-].

    Raises:
        EigenSolveError: residuals are too large, or the vectors are not orthonormal.
    """
    residuals = problem.residuals(pairs, floor)
    # Vectors whose λ differ by less than their residuals are mixed by round-off anyway.
    mixed = np.minimum(4.0 * np.maximum(residuals, np.roll(residuals, 1)), cluster_rtol)
    projections = problem.products(pairs.momenta, fields)
    rotation = align_clusters(pairs.values, projections, rtol=np.maximum(_SAME, mixed))
    pairs = pairs.rotated(rotation)
    residuals = problem.residuals(pairs, floor)
    _check_residuals(residuals, _round_off(problem, pairs, floor), tolerance)
    gram = problem.products(pairs.vectors, pairs.momenta)
    worst = float(np.abs(gram - np.eye(len(gram))).max())
    if not worst <= _ORTHONORMAL:
        raise EigenSolveError(
            f"the modes are orthonormal to {worst:.1e} only, {_ORTHONORMAL:.0e} is allowed; "
            "improve the mesh, or use another solver"
        )
    return pairs, residuals


def _round_off(problem: EigenProblem, pairs: Pairs, floor: float) -> Array:
    """The residuals (k,) [-] of a force ε diag(K) x, below which none can fall; collective."""
    diagonal = problem.stiffness.getDiagonal()
    terms = problem.norms(diagonal.array[:, None] * pairs.vectors)
    diagonal.destroy()
    scale = np.maximum(pairs.values, floor) * problem.norms(pairs.momenta)
    return float(np.finfo(float).eps) * terms / scale


def _check_residuals(residuals: Array, round_off: Array, tolerance: float | None) -> None:
    allowed = np.full_like(residuals, _RESIDUAL if tolerance is None else tolerance)
    if tolerance is None:
        allowed = np.maximum(allowed, np.minimum(_ROUND_OFF * round_off, _WORST_RESIDUAL))
    if not (residuals <= allowed).all():
        worst = int(np.argmax(np.nan_to_num(residuals / allowed, nan=np.inf)))
        raise EigenSolveError(
            f"mode {worst + 1} has the relative residual {residuals[worst]:.1e}, and "
            f"{allowed[worst]:.1e} is allowed; the mesh may hold slivers or materials of too "
            "different stiffness; improve it, or allow a larger residual_tolerance"
        )
    if tolerance is None and not (residuals <= _RESIDUAL).all():
        _log.warning(
            "round-off limits the residuals to %.1e: the body is very thin for its length, "
            "or its stiffness very uneven",
            float(residuals.max()),
        )
