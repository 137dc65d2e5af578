"""Loads upon a floating body: forces in the world's axes at its points, gravity, pushes on q."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.rotations import skew

Array = NDArray[np.float64]

_NO_MOMENT = np.zeros(3)


@dataclass(frozen=True, slots=True, eq=False)
class Loads:
    """Loads whose directions stay fixed in the world for one step.

    Args:
        push: generalised load (..., r) on the deformation alone, without a resultant.
        gravity: acceleration (..., 3) [m/s²], world; acts on the centre of mass alone.
        places: places X of the points at rest from the centre of mass (p, 3) [m].
        shapes: displacements of the points by the shapes, less their mean (p, 3, r).
        forces: upon the points (..., p, 3) [N], world.
    """

    push: Array
    gravity: Array
    places: Array
    shapes: Array
    forces: Array

    def resultant(self, mass: float) -> Array:
        """Sum of all forces (..., 3) [N], world."""
        return np.asarray(self.forces.sum(axis=-2) + mass * self.gravity)

    def at(self, q: Array, rotation: Array) -> "LoadsAtShape":
        """The loads in the frame's axes at coordinates (..., r) and a rotation (..., 3, 3)."""
        if not len(self.places):
            return LoadsAtShape(self.push, _NO_MOMENT, self.places, self.places)
        forces = self.forces @ rotation
        arms = self.places + (self.shapes @ q[..., None, :, None])[..., 0]
        push = self.push + (forces[..., None, :] @ self.shapes)[..., 0, :].sum(axis=-2)
        moment = (skew(arms) @ forces[..., None])[..., 0].sum(axis=-2)
        return LoadsAtShape(push, moment, forces, arms)

    def slopes(self, at: "LoadsAtShape") -> tuple[Array, Array, Array]:
        """Derivatives of push by turning (..., r, 3), of moment by q (..., 3, r) and by turning.

        To turn by a small vector t, in the frame's axes, changes a fixed force by F x t there.
        """
        turned = skew(at.forces)
        push = np.swapaxes(self.shapes, -1, -2) @ turned
        moment = -(turned @ self.shapes)
        turning = skew(at.arms) @ turned
        return push.sum(axis=-3), moment.sum(axis=-3), turning.sum(axis=-3)


@dataclass(frozen=True, slots=True, eq=False)
class LoadsAtShape:
    """Loads in the frame's axes.

    Args:
        push: generalised load on q (..., r).
        moment: about the centre of mass (..., 3) [N m].
        forces: upon the points (..., p, 3) [N].
        arms: from the centre of mass to the points (..., p, 3) [m].
    """

    push: Array
    moment: Array
    forces: Array
    arms: Array
