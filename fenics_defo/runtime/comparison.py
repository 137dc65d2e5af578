"""How alike two sets of modes are."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.runtime.modes import Modes

Array = NDArray[np.float64]


def mac(a: Modes | ArrayLike, b: Modes | ArrayLike, *, weights: ArrayLike | None = None) -> Array:
    """Compare two sets of shapes on the same nodes by the modal assurance criterion.

    MAC_ij = (a_i . b_j)^2 / ((a_i . a_i) (b_j . b_j)), with u . v = sum_p w_p u_p . v_p over the
    nodes p: 1 for proportional shapes, 0 for orthogonal ones, whatever their scale and sign.
    Lumped masses as weights make different modes of one body (nearly) orthogonal. Modes of equal
    frequency are defined only up to rotation among them: the MAC of such a pair means little.

    Args:
        a: ka modes, or shapes (ka, n, 3).
        b: kb modes, or shapes (kb, n, 3).
        weights: w (n,), not negative; all 1 by default.

    Returns:
        MAC (ka, kb) [-], between 0 and 1.

    Raises:
        ValueError: different numbers of nodes, shapes that vanish or are not finite, bad weights.

    References: Allemang & Brown, A correlation coefficient for modal vector analysis, Proc. 1st
        International Modal Analysis Conference, 1982.
    """
    first, second = _shape_array("a", a), _shape_array("b", b)
    nodes = first.shape[1]
    if second.shape[1] != nodes:
        raise ValueError(
            f"a has {nodes} nodes and b has {second.shape[1]}: the MAC needs shapes on the same "
            "nodes; interpolate one of them first"
        )
    w = np.ones(nodes) if weights is None else np.asarray(weights, dtype=float)
    if w.shape != (nodes,) or not ((w >= 0.0).all() and np.isfinite(w).all()):
        raise ValueError(f"weights must be {nodes} finite numbers that are not negative")
    left, right = _unit_rows("a", first, w), _unit_rows("b", second, w)
    # Round-off may exceed the bound of the Cauchy-Schwarz inequality by a few ulp.
    return np.minimum((left @ right.T) ** 2, 1.0)


def _shape_array(name: str, shapes: Modes | ArrayLike) -> Array:
    array = np.asarray(shapes.shapes if isinstance(shapes, Modes) else shapes, dtype=float)
    if array.ndim != 3 or array.shape[2] != 3:
        raise ValueError(f"{name} must have the shape (modes, nodes, 3), got {array.shape}")
    return array


def _unit_rows(name: str, shapes: Array, weights: Array) -> Array:
    """Return sqrt(w) u / |sqrt(w) u| as rows (k, 3 n)."""
    rows = (shapes * np.sqrt(weights)[:, None]).reshape(len(shapes), -1)
    # Scaling by the largest entry first keeps the squares of tiny and huge shapes in range.
    rows = rows / np.maximum(np.abs(rows).max(axis=1, initial=0.0), np.finfo(float).tiny)[:, None]
    lengths = np.linalg.norm(rows, axis=1)
    if not ((lengths > 0.0).all() and np.isfinite(lengths).all()):
        raise ValueError(f"{name} holds a shape that vanishes or is not finite")
    return rows / lengths[:, None]
