"""Energies of the invariants as functions of the principal stretches."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

_CYCLIC = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def of_stretches(
    respond: Callable[[Array, Array, Array], Sequence[Array]], stretches: Array
) -> tuple[Array, Array, Array]:
    """ψ (b,), ∂ψ/∂s (b, 3) and ∂²ψ/∂s² (b, 3, 3) [Pa] at stretches (b, 3).

    The stretches s are the singular values of F: I1 = Σ s_i², I2 = Σ_{i<j} s_i² s_j², J = s1 s2 s3.
    By the chain rule, with i, j, k distinct: ∂_i I1 = 2 s_i, ∂_i I2 = 2 s_i (I1 − s_i²),
    ∂_i J = s_j s_k; ∂_ii I1 = 2, ∂_ii I2 = 2 (I1 − s_i²), ∂_ij I2 = 4 s_i s_j, ∂_ij J = s_k.

    Args:
        respond: takes I1, I2, J (b,); returns ψ, its three first derivatives, and the six second
            ones on and above the diagonal, row by row.
        stretches: principal stretches; a view whose columns are contiguous is fastest.

    Returns:
        the three, the latter as views of arrays with the points last.
    """
    s = stretches.T
    squares, twice = s * s, 2.0 * s
    I1 = squares[0] + squares[1] + squares[2]
    others = np.stack([squares[j] + squares[k] for _, j, k in _CYCLIC])
    minors = np.stack([s[j] * s[k] for _, j, k in _CYCLIC])
    I2, J = squares[0] * squares[1] + squares[2] * others[2], s[0] * minors[0]
    energy, *rest = respond(I1, I2, J)
    slopes, curvatures = rest[:3], dict(zip(_PAIRS, rest[3:], strict=True))
    gradients = (twice, twice * others, minors)  # of I1, I2 and J, each (3, b)
    second = np.empty((3, 3, *J.shape))
    # Σ_b ∂²ψ/∂a∂b ∂_j b for a = I1, I2, J.
    mixed = [
        _dot([curvatures[min(a, b), max(a, b)] for b in range(3)], gradients) for a in range(3)
    ]
    for i, j, k in _CYCLIC:
        second[i, i] = _dot([gradient[i] for gradient in gradients], [m[i] for m in mixed])
        second[i, i] += 2.0 * (slopes[0] + slopes[1] * others[i])
        entry = _dot([gradient[i] for gradient in gradients], [m[j] for m in mixed])
        entry += slopes[1] * (twice[i] * twice[j]) + slopes[2] * s[k]
        second[i, j] = second[j, i] = entry
    return energy, _dot(slopes, gradients).T, second.transpose(2, 0, 1)


def _dot(a: Sequence[Array], b: Sequence[Array]) -> Array:
    result: Array = a[0] * b[0]
    result += a[1] * b[1]
    result += a[2] * b[2]
    return result
