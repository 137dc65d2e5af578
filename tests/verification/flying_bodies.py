"""Free bodies for comparing floating frames with full simulations and theory."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from bodies import Array
from scipy.linalg import eigh, null_space

from fenics_defo.analysis.rigid import rigid_motions
from fenics_defo.fem import Solid
from fenics_defo.reduction.floating_frame import inertia_integrals
from fenics_defo.runtime.floating import FloatingFrame


@dataclass(frozen=True)
class GalerkinLaw:
    """Uᵀ f(U q) of the finite elements themselves, as a force law."""

    solid: Solid
    shapes: Array

    def evaluator(self, shape: tuple[int, ...]) -> "GalerkinLaw":
        assert shape == (len(self.shapes),)
        return self

    def displacement(self, q: Array) -> Array:
        return np.tensordot(q, self.shapes, 1)

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        flat = self.shapes.reshape(len(self.shapes), -1)
        u = self.displacement(q)
        tangent = self.solid.tangent(u)
        return flat @ self.solid.internal_force(u).ravel(), flat @ (tangent @ flat.T)

    def energy(self, q: Array) -> float:
        return self.solid.energy(self.displacement(q))


@dataclass(frozen=True)
class MatrixLaw:
    """Linear elasticity: f = K q."""

    matrix: Array

    def evaluator(self, shape: tuple[int, ...]) -> "MatrixLaw":
        assert shape[-1] == len(self.matrix)
        return self

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        return q @ self.matrix, np.broadcast_to(self.matrix, (*q.shape[:-1], *self.matrix.shape))

    def energy(self, q: Array) -> Array:
        return np.asarray(0.5 * (q * (q @ self.matrix)).sum(axis=-1))


@dataclass(frozen=True)
class Flyer:
    """A model that stores all nodes."""

    law: Any
    frame: FloatingFrame
    points: Array
    shapes: Array
    damping: tuple[float, float] = (0.0, 0.0)

    @property
    def nodes(self) -> Any:
        return np.arange(len(self.points))


def deformations(solid: Solid) -> tuple[Array, Array]:
    """All vibration modes of a free body: squares of ω (3n - 6,), and shapes (3n - 6, n, 3).

    By a dense solver, in the space that is orthogonal in mass to the rigid motions.
    """
    mass, stiffness = solid.mass().toarray(), solid.tangent().toarray()
    rigid = rigid_motions(solid.points, solid.points.mean(axis=0)).reshape(6, -1)
    space = null_space(rigid @ mass)
    squares, vectors = eigh(space.T @ stiffness @ space, space.T @ mass @ space)
    return squares, (space @ vectors).T.reshape(-1, *solid.points.shape)


def galerkin_flyer(solid: Solid, shapes: Array, **options: Any) -> Flyer:
    """A reduced body whose elastic force is that of the finite elements."""
    frame = inertia_integrals(solid, shapes)
    stored = np.moveaxis(shapes, 0, -1)
    return Flyer(GalerkinLaw(solid, shapes), frame, solid.points, stored, **options)


def linear_flyer(solid: Solid, shapes: Array, **options: Any) -> Flyer:
    """A reduced body whose elastic force is linear in its frame."""
    flat = shapes.reshape(len(shapes), -1)
    matrix = flat @ (solid.tangent() @ flat.T)
    frame = inertia_integrals(solid, shapes)
    law = MatrixLaw(0.5 * (matrix + matrix.T))
    return Flyer(law, frame, solid.points, np.moveaxis(shapes, 0, -1), **options)
