"""A law of the principal stretches, continued below a threshold so that it stands inversion."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]
type Parameter = Array | float

#: Takes stretches (b, 3) and the law's parameters, each a number or (b,); returns ψ (b,),
#: ∂ψ/∂s (b, 3) and ∂²ψ/∂s² (b, 3, 3) [Pa], symmetric in the stretches.
type Derivatives = Callable[..., tuple[Array, Array, Array]]

# Relative step of the central difference that gives third derivatives: its own error is the square
# of it, and that of round-off 1e-16 over it, so that both stay near 1e-10.
_STEP = 1e-5


@dataclass(frozen=True, slots=True)
class PrincipalState:
    """A law at principal stretches, components first.

    Args:
        energy: ψ (b,) [Pa].
        stress: ∂ψ/∂s (3, b) [Pa].
        curvature: ∂²ψ/∂s² (3, 3, b) [Pa]; None where not asked for.
    """

    energy: Array
    stress: Array
    curvature: Array | None


def continued(
    stretches: Array,
    derivatives: Derivatives,
    parameters: tuple[Parameter, ...],
    *,
    threshold: float,
    curvature: bool,
) -> PrincipalState:
    """Energy, principal stresses and their derivatives at signed stretches.

    With ŝ = max(s, threshold), d = s − ŝ ≤ 0, g = ∂ψ/∂s and H = ∂²ψ/∂s² at ŝ,

        ψ̃ = ψ(ŝ) + g·d + k/2 d·d.

    The principal stress of a stretch below the threshold is therefore g_i + k d_i, continued
    linearly; that of one above it, g_j + H_ji d_i: all are derivatives of one energy, which has a
    continuous first derivative. k is a constant of the law, the larger of its ∂²ψ/∂s3² at the
    stretches (1, 1, threshold) and at rest. (H_ii at ŝ itself, which turns negative where the other
    two stretches are large, would pull a point further inside out.)

    Args:
        stretches: s (3, b), of any sign.
        derivatives: the law's, at stretches of at least ``threshold``.
        parameters: what ``derivatives`` takes beside the stretches, numbers or (b,).
        threshold: between 0 and 1.
        curvature: whether the second derivatives are wanted.

    Returns:
        the state at the b points.
    """
    clamped = np.maximum(stretches, threshold)
    energy, slope, second = _components(derivatives(clamped.T, *parameters), clamped.shape[1])
    below = stretches < threshold
    if not below.any():
        return PrincipalState(energy, slope, second if curvature else None)
    d = stretches - clamped
    k = _stiffness(derivatives, parameters, threshold)
    energy = energy + (slope * d).sum(axis=0) + 0.5 * k * (d * d).sum(axis=0)
    coupled = second[:, 0] * d[0] + second[:, 1] * d[1] + second[:, 2] * d[2]
    stress = slope + np.where(below, k * d, coupled)
    if not curvature:
        return PrincipalState(energy, stress, None)
    second = second.copy()
    some = np.flatnonzero(below.any(axis=0))
    second[:, :, some] += _third(clamped[:, some], d[:, some], derivatives, _some(parameters, some))
    both = below[:, None] & below
    second[both] = 0.0
    for i in range(3):
        second[i, i] = np.where(below[i], k, second[i, i])
    return PrincipalState(energy, stress, second)


def _components(answer: tuple[Array, Array, Array], count: int) -> tuple[Array, Array, Array]:
    energy, slope, second = answer
    return energy, slope.T, second.transpose(1, 2, 0)


def _stiffness(
    derivatives: Derivatives, parameters: tuple[Parameter, ...], threshold: float
) -> Array:
    """k, see `continued`: (1,), or (b,) if a parameter is a field."""
    count = max((np.size(p) for p in parameters), default=1)
    pressed, rest = np.ones((3, count)), np.ones((3, count))
    pressed[2] = threshold
    at_threshold, at_rest = (derivatives(s.T, *parameters)[2][:, 2, 2] for s in (pressed, rest))
    return np.maximum(at_threshold, at_rest)


def _third(
    clamped: Array, d: Array, derivatives: Derivatives, parameters: tuple[Parameter, ...]
) -> Array:
    """Σ_k d_k ∂³ψ/∂s_i∂s_j∂s_k (3, 3, n) for the stretches i and j above the threshold."""
    size = np.sqrt((d * d).sum(axis=0))
    step = _STEP * clamped.min(axis=0)
    shift = d * (step / size)
    ahead, behind = (
        derivatives((clamped + sign * shift).T, *parameters)[2] for sign in (1.0, -1.0)
    )
    free = (d == 0.0).astype(np.float64)
    change = (ahead - behind).transpose(1, 2, 0) * (size / (2.0 * step))
    return change * free[:, None] * free


def _some(parameters: tuple[Parameter, ...], points: NDArray[np.intp]) -> tuple[Parameter, ...]:
    return tuple(p[points] if isinstance(p, np.ndarray) and p.size > 1 else p for p in parameters)
