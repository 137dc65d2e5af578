"""What the inertia of a deforming, turning body is made of, at any of its shapes.

In the frame's axes, with spin w and rates q', the motion relative to the centre of mass has

    kinetic energy     w . I(q) w / 2 + w . A(q) q' + q' . M q' / 2
    angular momentum   I(q) w + A(q) q'
    momenta of q       M q' + A(q)^T w

and its equations of motion, with f the elastic force and Q the loads, are

    M q'' + A(q)^T w' - 2 G(w) q' - c(q, w) + f(q) = Q              G skew: Coriolis
    d/dt (R (I(q) w + A(q) q')) = moment of the loads                A^T w': Euler; c: centrifugal

Shabana, Dynamics of Multibody Systems, section 5; Terzopoulos and Witkin, Physically based models
with rigid and deformable components (1988), who split deformable bodies in this way; and, for the
same inertia forces upon a reduced body, the course of Sifakis and Barbic, FEM Simulation of 3D
Deformable Solids (SIGGRAPH 2012), part 2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.frame import PAIRS, FloatingFrame
from fenics_defo.runtime.floating.rotations import LEVI_CIVITA

Array = NDArray[np.float64]

_EYE = np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class InertiaAtShape:
    """The inertia at coordinates q (..., r).

    Args:
        moments: W_abi = int rho (X + U q)_a U_bi dV (..., 3, 3, r).
        inertia: I about the centre of mass (..., 3, 3) [kg m²].
        coupling: A (..., 3, r); A_ki = e_kab W_abi.
    """

    moments: Array
    inertia: Array
    coupling: Array

    def inertia_slope(self, spin: Array) -> Array:
        """d(I w)_k / dq (..., 3, r) at a spin w (..., 3) [rad/s].

        The centrifugal force is half its product with w.
        """
        w = self.moments
        trace = w[..., 0, 0, :] + w[..., 1, 1, :] + w[..., 2, 2, :]
        both = w + np.swapaxes(w, -3, -2)
        turned = (spin[..., None, None, :] @ both)[..., 0, :]
        return np.asarray(2.0 * spin[..., None] * trace[..., None, :] - turned)


class Inertia:
    """Evaluates the inertia of a frame at any shape and spin; all arrays take leading axes.

    Args:
        frame: the integrals of mass.
        coupled: False neglects the inertial coupling: A, G and c vanish, I stays that at rest.
    """

    def __init__(self, frame: FloatingFrame, *, coupled: bool = True) -> None:
        r = frame.size
        blocks = np.zeros((3, 3, r, r))
        if coupled:
            for (a, b), block in zip(PAIRS, frame.quadratic, strict=True):
                blocks[a, b], blocks[b, a] = block, block.T
        #: M (r, r).
        self.mass: Array = frame.shape_mass
        self._second = frame.second_moment
        self._linear = frame.linear if coupled else np.zeros_like(frame.linear)
        # (r, 9 r): q times it is the part of W that is linear in q.
        self._of_shape = np.ascontiguousarray(blocks.transpose(2, 0, 1, 3).reshape(r, 9 * r))
        gyro = np.stack([blocks[b, c] - blocks[c, b] for b, c in ((1, 2), (2, 0), (0, 1))])
        self._gyro = gyro.reshape(3 * r, r)
        self._gyro_rows = gyro.reshape(3, r * r)
        self._squares = -blocks.reshape(9, r * r)
        if coupled:
            self._squares[::4] += self.mass.ravel()

    def at(self, q: Array) -> InertiaAtShape:
        """The inertia at coordinates q (..., r)."""
        r = q.shape[-1]
        moments = self._linear + (q @ self._of_shape).reshape(*q.shape[:-1], 3, 3, r)
        column = q[..., None, :, None]
        first = (np.swapaxes(self._linear, 0, 1) @ column)[..., 0]
        second = self._second + first + (moments @ column)[..., 0]
        trace = second[..., 0, 0] + second[..., 1, 1] + second[..., 2, 2]
        coupling = LEVI_CIVITA @ moments.reshape(*q.shape[:-1], 9, r)
        return InertiaAtShape(moments, trace[..., None, None] * _EYE - second, coupling)

    def gyroscopic_rows(self, rates: Array) -> Array:
        """G_k q' (..., 3, r) for unit spins about the axes; G(w) q' is their sum by w."""
        r = rates.shape[-1]
        return np.asarray((rates @ self._gyro.T).reshape(*rates.shape[:-1], 3, r))

    def turning(self, spin: Array) -> tuple[Array, Array]:
        """G(w), skew, and the slope dc/dq = w² M - w_a w_b N_ab, both (..., r, r)."""
        shape = (*spin.shape[:-1], *self.mass.shape)
        pairs = (spin[..., :, None] * spin[..., None, :]).reshape(*spin.shape[:-1], 9)
        return (spin @ self._gyro_rows).reshape(shape), (pairs @ self._squares).reshape(shape)
