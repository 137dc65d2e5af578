"""Uniform pieces of bars and beams in harmonic motion, as linear systems along the axis."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BarPiece:
    """Uniform bar in tension or torsion: displacement u, force S u'.

    Args:
        length: [m].
        stiffness: S = E A [N], or G J [N m^2] in torsion.
        inertia: per length, rho A [kg/m], or rho I_p [kg m] in torsion.
    """

    length: float
    stiffness: float
    inertia: float

    def wave_number(self, omega: Array) -> Array:
        """Omega sqrt(inertia / stiffness) [1/m], shape of ``omega``."""
        return omega * np.sqrt(self.inertia / self.stiffness)

    def system(self, omega: Array) -> Array:
        """A of (u, N)' = A (u, N), shape (k, 2, 2)."""
        matrix = np.zeros((*omega.shape, 2, 2))
        matrix[..., 0, 1] = 1.0 / self.stiffness
        matrix[..., 1, 0] = -self.inertia * omega**2
        return matrix


@dataclass(frozen=True, slots=True)
class BeamPiece:
    """Uniform beam in one plane: deflection w, section rotation psi, shear force Q, moment M.

    w' = psi + c Q, psi' = M / B, Q' = -m omega^2 w, M' = -Q - j omega^2 psi: the equations of
    Timoshenko (Phil. Mag. 41 (1921) 744), and of Euler-Bernoulli with c = j = 0.

    Args:
        length: [m].
        bending_stiffness: B = E I [N m^2].
        mass: m = rho A [kg/m].
        shear_flexibility: c = 1 / (kappa G A) [1/N].
        rotary_inertia: j = rho I [kg m].
    """

    length: float
    bending_stiffness: float
    mass: float
    shear_flexibility: float = 0.0
    rotary_inertia: float = 0.0

    def wave_number(self, omega: Array) -> Array:
        """The larger root k [1/m] of (k^2 - a)(k^2 - b) = omega^2 m / B, shape of ``omega``.

        a = j omega^2 / B, b = c m omega^2. The other root, real or imaginary, is the smaller.
        """
        a = self.rotary_inertia / self.bending_stiffness * omega**2
        b = self.shear_flexibility * self.mass * omega**2
        spread = np.hypot(a - b, 2.0 * omega * np.sqrt(self.mass / self.bending_stiffness))
        return np.sqrt(0.5 * (a + b + spread))

    def system(self, omega: Array) -> Array:
        """A of (w, psi, Q, M)' = A (w, psi, Q, M), shape (k, 4, 4)."""
        matrix = np.zeros((*omega.shape, 4, 4))
        matrix[..., 0, 1] = 1.0
        matrix[..., 0, 2] = self.shear_flexibility
        matrix[..., 1, 3] = 1.0 / self.bending_stiffness
        matrix[..., 2, 0] = -self.mass * omega**2
        matrix[..., 3, 1] = -self.rotary_inertia * omega**2
        matrix[..., 3, 2] = -1.0
        return matrix


type Piece = BarPiece | BeamPiece
