"""Small models whose forces are written down by hand, for the tests of the integrators."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.forces import LinearForce

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Springs:
    """W = ½ qᵀ K q + sum of (third/6 s³ + fourth/24 s⁴) with s = A q."""

    kind: ClassVar[str] = "springs"
    ARRAYS: ClassVar[Mapping[str, Any]] = {}

    linear: Array
    directions: Array
    third: float = 0.0
    fourth: float = 0.0

    @property
    def size(self) -> int:
        return len(self.linear)

    def force(self, q: Array) -> Array:
        s = q @ self.directions.T
        return np.asarray(
            q @ self.linear + (0.5 * self.third * s**2 + self.fourth / 6.0 * s**3) @ self.directions
        )

    def stiffness(self, q: Array) -> Array:
        s = q @ self.directions.T
        spring = self.third * s + 0.5 * self.fourth * s**2
        return np.asarray(
            self.linear + (self.directions.T * spring[..., None, :]) @ self.directions
        )

    def energy(self, q: Array) -> Array:
        s = q @ self.directions.T
        more = (self.third / 6.0 * s**3 + self.fourth / 24.0 * s**4).sum(axis=-1)
        return np.asarray(0.5 * np.vecdot(q, q @ self.linear) + more)

    def evaluator(self, shape: tuple[int, ...]) -> "SpringsEvaluator":
        return SpringsEvaluator(self, shape)

    def arrays(self) -> dict[str, NDArray[Any]]:
        raise NotImplementedError

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Springs":
        raise NotImplementedError


class SpringsEvaluator:
    """Overwrites its answers with each call, as those of the package do."""

    def __init__(self, law: Springs, shape: tuple[int, ...]) -> None:
        self._law = law
        self._force, self._stiffness = np.empty(shape), np.empty((*shape, shape[-1]))
        self._shape = shape

    def force(self, q: Array) -> Array:
        assert q.shape == self._shape
        self._force[...] = self._law.force(q)
        return self._force

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        self._stiffness[...] = self._law.stiffness(q)
        return self.force(q), self._stiffness


@dataclass(frozen=True)
class Model:
    """What the integrators ask of a reduced model."""

    law: Any
    mass: Array
    damping: tuple[float, float] = (0.0, 0.0)
    size: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", len(self.mass))

    def energy(self, q: Array) -> Array:
        return np.asarray(self.law.energy(q))


def positive(rng: np.random.Generator, values: Array) -> Array:
    """A symmetric matrix with these eigenvalues."""
    turn = np.linalg.qr(rng.normal(size=(len(values), len(values))))[0]
    matrix = (turn * values) @ turn.T
    return np.asarray(0.5 * (matrix + matrix.T))


def stiffening(
    r: int = 4, *, unit_mass: bool = False, third: float = 3.0, fourth: float = 90.0, seed: int = 1
) -> Model:
    """A nonlinear model with full matrices and frequencies of some rad/s."""
    rng = np.random.default_rng(seed)
    law = Springs(
        positive(rng, np.linspace(4.0, 60.0, r)), rng.normal(size=(r + 1, r)), third, fourth
    )
    mass = np.eye(r) if unit_mass else positive(rng, np.linspace(0.5, 2.0, r))
    return Model(law, mass)


def linear(r: int = 4, *, kind: str = "full", seed: int = 2) -> Model:
    """A linear model: "modal" with M = 1 and a diagonal K, or with "full" matrices."""
    rng = np.random.default_rng(seed)
    squares = np.linspace(4.0, 60.0, r)
    if kind == "modal":
        return Model(LinearForce(np.diag(squares)), np.eye(r))
    return Model(LinearForce(positive(rng, squares)), positive(rng, np.linspace(0.5, 2.0, r)))


def oscillator(
    omega: float, *, third: float = 0.0, fourth: float = 0.0, is_linear: bool = False
) -> Model:
    """One coordinate of unit mass."""
    stiffness = np.array([[omega**2]])
    law = LinearForce(stiffness) if is_linear else Springs(stiffness, np.eye(1), third, fourth)
    return Model(law, np.eye(1))
