"""Deformation gradients on which the laws at points are tried, and the derivatives' tests."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

EPSILON = np.finfo(np.float64).eps


def rotations(count: int, seed: int) -> Array:
    """Random proper rotations (count, 3, 3)."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(count, 3, 3)))
    return Q * np.sign(np.linalg.det(Q))[:, None, None]


def composed(stretches: Array, seed: int = 11) -> Array:
    """U diag(s) Vᵀ with random proper rotations, for stretches (m, 3)."""
    s = np.atleast_2d(np.asarray(stretches, dtype=np.float64))
    return (rotations(len(s), seed) * s[:, None]) @ rotations(len(s), seed + 1)


def around(*stretches: float, count: int = 8, size: float = 0.03, seed: int = 12) -> Array:
    """Points whose signed stretches are scattered about the given ones."""
    noise = size * np.random.default_rng(seed).uniform(-1, 1, (count, 3))
    return composed(np.array(stretches) + noise)


def repeated(*stretches: float, count: int = 8) -> Array:
    """Points with exactly the given stretches, up to round-off."""
    return composed(np.tile(stretches, (count, 1)))


#: Kinds of points at which every smooth law must be right; s2 + s3 stays above 0.3.
REGULAR = {
    "random": around(1.2, 1.0, 0.7, size=0.2),
    "near rest": around(1.0, 1.0, 1.0, size=1e-6),
    "rest": repeated(1.0, 1.0, 1.0),
    "stretched": around(3.0, 1.5, 0.5),
    "nearly singular": around(1.2, 0.8, 0.0, size=1e-7),
    "flat": repeated(1.2, 0.8, 0.0),
    "inverted": around(1.3, 1.0, -0.4),
    "two equal": repeated(1.1, 1.1, 0.6),
    "two smaller equal": repeated(1.4, 0.7, 0.7),
    "nearly equal": around(1.1, 1.1, 0.8, size=1e-9),
    "equal and inverted": repeated(1.2, 1.2, -0.5),
    "crushed": around(0.7, 0.4, 0.05, size=0.02),
}

#: Points without a unique rotation, or at the ends of the range.
HARD = {
    "line": repeated(1.3, 0.0, 0.0),
    "point": np.zeros((3, 3, 3)),
    "turned inside out": repeated(1.0, 1.0, -1.0),
    "minus one": -np.tile(np.eye(3), (3, 1, 1)),
    "nearly a line": composed(np.tile([1.0, 1e-9, -3e-10], (8, 1))),
    "graded": composed(10.0 ** np.random.default_rng(5).uniform(-20, 5, (50, 3))),
    "scattered": np.random.default_rng(6).normal(size=(300, 3, 3)),
}
EVERY = REGULAR | HARD


def sizes(F: Array) -> Array:
    """Largest singular value of each matrix (m,), not zero."""
    return np.linalg.norm(F, axis=(1, 2)) + 1e-300


def check_derivative(
    function: Callable[[Array], Array], derivative: Array, F: Array, *, step: float = 4e-3
) -> None:
    """``derivative`` (m, ..., 3, 3) is that of ``function``, by central differences of order 2."""
    H = np.random.default_rng(13).uniform(-1, 1, F.shape)
    exact = np.einsum("m...ij,mij->m...", derivative, H)
    scale = np.abs(exact).max() + np.abs(function(F + 0.05 * H)).max()

    def error(h: float) -> float:
        difference = (function(F + h * H) - function(F - h * H)) / (2.0 * h)
        return float(np.abs(difference - exact).max())

    coarse, fine = error(step), error(step / 2)
    if coarse > 1e-8 * scale:  # else the function is quadratic along H, and round-off is all
        assert abs(np.log2(coarse / fine) - 2.0) < 0.15
    assert error(1e-5) < 1e-7 * scale


def eigenvalues(tangent: Array) -> Array:
    """Eigenvalues (m, 9) of tangents (m, 3, 3, 3, 3), relative to the largest entry of each."""
    matrices = tangent.reshape(-1, 9, 9)
    scale = np.abs(matrices).max(axis=(1, 2))[:, None]
    return np.linalg.eigvalsh(matrices) / scale


def hooke(mu: float, lmbda: float) -> Array:
    """λ δij δkl + μ (δik δjl + δil δjk), (3, 3, 3, 3)."""
    one = np.eye(3)
    shear = np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
    return lmbda * np.einsum("ij,kl->ijkl", one, one) + mu * shear
