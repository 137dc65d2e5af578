"""Dimensionless wave numbers of uniform beams and bars."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.beams.checks import require_count
from fenics_defo.beams.supports import bar_supports, beam_supports

type Array = NDArray[np.float64]

# The iteration for the angle shrinks its error by sech(1.875) = 0.3 or better each time.
_ITERATIONS = 40


def bending_roots(count: int, *, supports: str = "clamped-free") -> Array:
    """Dimensionless wave numbers x = beta L of a uniform Euler-Bernoulli beam.

    The positive roots of the frequency equations: cos x cosh x = -1 (clamped-free), = 1
    (clamped-clamped, free-free); tan x = tanh x (clamped-pinned, free-pinned), = -tanh x
    (clamped-sliding, free-sliding); sin x = 0 (pinned-pinned, sliding-sliding); cos x = 0
    (pinned-sliding). Each is solved as an angle beside its asymptote, with exp(-x) in place of
    cosh x: no index overflows or loses digits.

    Args:
        count: how many.
        supports: two of "clamped", "pinned", "sliding", "free" with a hyphen, in either order.

    Returns:
        Roots [-], (count,), ascending; rigid motions (x = 0) left out.

    Raises:
        BeamError: unknown supports, or a count below 1.

    References:
        Rayleigh, The Theory of Sound, vol. 1, chapter VIII; Blevins, Formulas for Natural
        Frequency and Mode Shape, table of single-span beams.
    """
    n = np.arange(1, require_count(count) + 1, dtype=np.float64)
    ends = set(beam_supports(supports).kinds)
    sign = np.where(n % 2 == 1, 1.0, -1.0)
    if ends == {"clamped", "free"}:
        return _beside(np.pi * (n - 0.5), lambda x: np.arcsin(sign * _sech(x)))
    if ends <= {"clamped", "free"}:
        return _beside(np.pi * (n + 0.5), lambda x: np.arcsin(sign * _sech(x)))
    if ends in ({"clamped", "pinned"}, {"free", "pinned"}):
        return _beside(np.pi * (n + 0.25), lambda x: -np.arctan(np.exp(-2.0 * x)))
    if ends in ({"clamped", "sliding"}, {"free", "sliding"}):
        return _beside(np.pi * (n - 0.25), lambda x: np.arctan(np.exp(-2.0 * x)))
    if ends == {"pinned", "sliding"}:
        return np.pi * (n - 0.5)
    return np.pi * n


def bar_roots(count: int, *, ends: str = "fixed-free") -> Array:
    """Dimensionless wave numbers k L of a uniform bar, (count,), rigid motion left out.

    (n - 1/2) pi if one end is fixed, n pi if both or none are.

    Raises:
        BeamError: unknown ends, or a count below 1.
    """
    n = np.arange(1, require_count(count) + 1, dtype=np.float64)
    kinds = bar_supports(ends).kinds
    return np.pi * (n if kinds[0] == kinds[1] else n - 0.5)


def _sech(x: Array) -> Array:
    return 2.0 * np.exp(-x) / (1.0 + np.exp(-2.0 * x))


def _beside(asymptote: Array, angle: Callable[[Array], Array]) -> Array:
    """Solve x = asymptote + angle(x) by repetition."""
    roots = asymptote
    for _ in range(_ITERATIONS):
        roots = asymptote + angle(roots)
    return roots
