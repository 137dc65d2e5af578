"""Cheap reasons why a candidate cannot be good enough."""

from fenics_defo.scene.trade.choosing import percent
from fenics_defo.scene.trade.records import ModelSpec

# Times the tolerance: what is near is measured all the same, to be shown as a near miss.
_FAR = 3.0
# ½ uᵀ K u over the strain energy. Where a body turns, the first counts the turn as strain.
_BENT = 2.0
_NEAR = 1.25  # the same, where nonlinear parts are a correction
_COARSE = 0.2  # tolerances above which even that may do


def far_from(
    spec: ModelSpec,
    *,
    tolerance: float,
    best_error: float | None,
    energy_ratio: float | None,
    is_linear: bool,
) -> str:
    """Why a model cannot meet a tolerance, or nothing.

    Args:
        spec: model.
        tolerance: error that is allowed [-].
        best_error: the least that its basis allows [-]; None: not known.
        energy_ratio: see `Reference`.
        is_linear: whether the body's own law is.
    """
    if best_error is not None and best_error > _FAR * tolerance:
        return (
            f"its basis misses {percent(best_error)} of the motion at best, and "
            f"{percent(tolerance)} is allowed"
        )
    ratio = energy_ratio
    if spec.force != "linear" or is_linear or ratio is None or tolerance > _COARSE:
        return ""
    if not 1.0 / _BENT <= ratio <= _BENT:
        return (
            f"linear forces would store {ratio:.3g} times the strain energy at the largest "
            "displacement: the body bends too far for them"
        )
    return ""


def is_near_rest(energy_ratio: float | None) -> bool:
    """Whether a motion stays where the stiffness at rest tells most of the forces.

    Args:
        energy_ratio: see `Reference`.
    """
    return energy_ratio is not None and 1.0 / _NEAR <= energy_ratio <= _NEAR
