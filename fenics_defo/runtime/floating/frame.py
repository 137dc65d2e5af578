"""The integrals of mass behind the inertia forces of a floating frame of reference."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.archive import ArraySpec

Array = NDArray[np.float64]

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Axes (a, b) of the blocks of `FloatingFrame.quadratic`, in this order."""

# Least eigenvalue of the inertia, relative to the largest, of a body that is not a needle.
_NEEDLE = 1e-12
_SYMMETRY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FloatingFrame:
    """Integrals of mass of a body of r shapes, exact for its consistent mass.

    With X the places at rest from the centre of mass and U the shapes less their mean
    displacement, so that the frame's origin stays in the centre of mass whatever q is:

        P_ab  = int rho X_a X_b dV           second moments at rest
        B_abi = int rho X_a U_bi dV          first order in q
        N_ab  = int rho U_a^T U_b dV         second order in q; N_xx + N_yy + N_zz is the mass of q

    They give, for any q, the inertia about the centre of mass, its coupling with the rates of q,
    and the Coriolis and centrifugal forces: the inertia shape integrals of Shabana, Dynamics of
    Multibody Systems, chapter 5.

    Taking the mean out of the shapes changes no motion: what it moves, the centre of mass moves
    back. How the frame turns is up to the shapes. Where they are orthogonal in mass to the rigid
    rotations, as the modes of a free body are, int rho X x (U q') dV = 0, which is the linearised
    Tisserand or mean-axis condition: the angular momentum of the deformation is then of second
    order in q; see `axis_defect`. Other shapes serve as well, with frames of their own, as long as
    no combination of them is a rotation.

    Args:
        mass: of the body [kg].
        centre: of mass, at rest (3,) [m].
        second_moment: P (3, 3) [kg m²].
        mean: mean displacement of the shapes as they are given, int rho U dV / mass (3, r), in m
            per unit of q.
        linear: B (3, 3, r) [kg m²].
        quadratic: N_ab (6, r, r) [kg m²] for the axes of `PAIRS`; N_ba is the transpose.

    Raises:
        ValueError: arrays whose shapes or values do not fit together.
    """

    ARRAYS: ClassVar[dict[str, ArraySpec]] = {
        "frame_mass": ArraySpec("f", 0),
        "frame_centre": ArraySpec("f", 1),
        "frame_second_moment": ArraySpec("f", 2),
        "frame_mean": ArraySpec("f", 2),
        "frame_linear": ArraySpec("f", 3),
        "frame_quadratic": ArraySpec("f", 3),
    }
    UNITS: ClassVar[dict[str, str]] = {
        "frame_mass": "kg",
        "frame_centre": "m",
        "frame_second_moment": "kg m^2",
        "frame_mean": "m per unit of q",
        "frame_linear": "kg m^2 per unit of q",
        "frame_quadratic": "kg m^2 per unit of q squared",
    }

    mass: float
    centre: Array
    second_moment: Array
    mean: Array
    linear: Array
    quadratic: Array

    def __post_init__(self) -> None:
        r = np.shape(self.mean)[-1] if np.ndim(self.mean) == 2 else -1
        object.__setattr__(self, "mass", float(self.mass))
        shapes = {"centre": (3,), "second_moment": (3, 3), "mean": (3, r), "linear": (3, 3, r)}
        shapes["quadratic"] = (6, r, r)
        for name, shape in shapes.items():
            given = np.array(getattr(self, name), dtype=np.float64)
            if given.shape != shape:
                raise ValueError(f"{name} has the shape {given.shape}, which does not fit {shape}")
            if not np.isfinite(given).all():
                raise ValueError(f"{name} of a floating frame holds values that are not finite")
            given.flags.writeable = False
            object.__setattr__(self, name, given)
        self._check_values()

    def _check_values(self) -> None:
        if not 0.0 < self.mass < np.inf:
            raise ValueError(f"the mass of a floating frame must be positive, got {self.mass!r}")
        for name, block in (("second_moment", self.second_moment), ("N", self.quadratic[:3])):
            skew = block - np.swapaxes(block, -1, -2)
            if not np.abs(skew).max(initial=0.0) <= _SYMMETRY * np.abs(block).max(initial=0.0):
                raise ValueError(f"{name} of a floating frame is not symmetric")
        principal = np.linalg.eigvalsh(self.inertia)
        if not principal[0] > _NEEDLE * principal[-1]:
            raise ValueError("the inertia of a floating frame is not positive definite")

    @property
    def size(self) -> int:
        """Number of shapes r."""
        return self.mean.shape[1]

    @property
    def inertia(self) -> Array:
        """Inertia at rest about the centre of mass (3, 3) [kg m²], tr(P) 1 - P."""
        return np.asarray(np.trace(self.second_moment) * np.eye(3) - self.second_moment)

    @property
    def shape_mass(self) -> Array:
        """Mass matrix (r, r) of the shapes less their mean, N_xx + N_yy + N_zz [kg m²]."""
        return np.asarray(self.quadratic[:3].sum(axis=0))

    @property
    def turning_moment(self) -> Array:
        """Angular momentum at rest per rate of q, a_i = int rho X x U_i dV (3, r) [kg m²]."""
        b = self.linear
        return np.stack([b[1, 2] - b[2, 1], b[2, 0] - b[0, 2], b[0, 1] - b[1, 0]])

    @property
    def axis_defect(self) -> float:
        """How far the frame is from the mean axes at rest: 0, to round-off, where it is theirs [-].

        The largest share that a rigid rotation has in a shape: (a_i . I^-1 a_i / M_ii)^(1/2) with
        `turning_moment` a_i; 1 for a shape that is a rotation.
        """
        moment = self.turning_moment
        share = (moment * np.linalg.solve(self.inertia, moment)).sum(axis=0)
        mass = np.diagonal(self.shape_mass)
        ratio = np.divide(share, mass, out=np.zeros_like(share), where=mass > 0.0)
        return float(np.sqrt(np.abs(ratio).max(initial=0.0)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a model file holds of the frame, by the names of `ARRAYS`."""
        return {n: np.asarray(getattr(self, n.removeprefix("frame_"))) for n in self.ARRAYS}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Return the frame whose `arrays` these are, bit by bit; others among them are not read.

        Raises:
            ValueError: they do not fit together.
        """
        values: dict[str, Any] = {n.removeprefix("frame_"): arrays[n] for n in cls.ARRAYS}
        return cls(**values)
