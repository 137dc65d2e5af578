"""Clouds of point masses: bodies whose inertia can be summed up point by point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating import FloatingFrame
from fenics_defo.runtime.floating.frame import PAIRS
from fenics_defo.runtime.forces import ForceLaw, LinearForce

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cloud:
    """Point masses (p,) at points (p, 3) with shapes (p, 3, r); a model for `FloatingBody`.

    ``law`` is linear; ``frame`` is summed up over the points.
    """

    masses: Array
    points: Array
    shapes: Array
    law: ForceLaw
    damping: tuple[float, float] = (0.0, 0.0)

    @property
    def nodes(self) -> NDArray[np.int64]:
        return 10 + np.arange(len(self.points))

    @property
    def frame(self) -> FloatingFrame:
        m = self.masses
        centre, mean = m @ self.points / m.sum(), np.tensordot(m, self.shapes, 1) / m.sum()
        x, u = self.points - centre, self.shapes - mean
        blocks = [np.einsum("pi,p,pj->ij", u[:, a], m, u[:, b]) for a, b in PAIRS]
        return FloatingFrame(
            mass=m.sum(),
            centre=centre,
            second_moment=np.einsum("pa,p,pb->ab", x, m, x),
            mean=mean,
            linear=np.einsum("pa,p,pbi->abi", x, m, u),
            quadratic=np.stack(blocks),
        )


def cloud(
    size: int = 4, *, seed: int = 1, tisserand: bool = True, stiffness: float = 40.0
) -> Cloud:
    """Twelve random masses with ``size`` random shapes of unit mass matrix.

    Without ``tisserand`` the shapes keep what they have of rigid motions, and of each other.
    """
    rng = np.random.default_rng(seed)
    masses = rng.uniform(0.5, 1.5, 12)
    points = rng.normal(size=(12, 3)) * (1.5, 0.8, 0.4)
    shapes = rng.normal(size=(12, 3, size))
    if tisserand:
        arm = points - masses @ points / masses.sum()
        rigid = np.stack([np.broadcast_to(e, arm.shape) for e in np.eye(3)], axis=-1)
        turns = np.stack([np.cross(e, arm) for e in np.eye(3)], axis=-1)
        every = np.concatenate([rigid, turns, shapes], axis=-1).reshape(36, -1)
        root = np.sqrt(np.repeat(masses, 3))[:, None]
        triangle = np.linalg.qr(root * every, mode="r")
        shapes = (every @ np.linalg.inv(triangle))[:, 6:].reshape(12, 3, size)
    law = LinearForce(np.diag(stiffness * np.linspace(1.0, 5.0, size)))
    return Cloud(masses, points, shapes, law)
