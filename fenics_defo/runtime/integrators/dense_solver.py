"""One dense system a step, or a batch of them, with as little around LAPACK as NumPy allows.

For ten unknowns `numpy.linalg.solve` spends more time on its arguments than LAPACK on the system.
The universal function that it calls is not a public name, so that it is taken only where it is
there and gives what the public one gives.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Solves A x = b for A (..., r, r), b (..., r); the third argument takes x. A singular matrix gives
#: NaN or raises LinAlgError.
type Solve = Callable[[Array, Array, Array], object]


def _public(matrix: Array, right_side: Array, out: Array) -> None:
    out[...] = np.linalg.solve(matrix, right_side[..., None])[..., 0]


def _find() -> Solve:
    bare: Solve | None = getattr(getattr(np.linalg, "_umath_linalg", None), "solve1", None)
    matrix = np.array([[[4.0, 1.0], [1.0, 3.0]], [[2.0, 1.0], [1.0, 5.0]]])
    right_side = np.array([[1.0, 2.0], [5.0, 6.0]])
    expected, found = np.empty((2, 2)), np.zeros((2, 2))
    _public(matrix, right_side, expected)
    try:
        if bare is not None:
            bare(matrix, right_side, found)
    except (TypeError, ValueError):
        return _public
    return bare if bare is not None and np.allclose(found, expected) else _public


solve: Solve = _find()
