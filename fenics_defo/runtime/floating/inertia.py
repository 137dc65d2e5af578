"""What the inertia of a deforming, turning body is made of, at any of its shapes.

In the frame's axes, with spin w and rates q', the motion relative to the centre of mass has

    kinetic energy     w . I(q) w / 2 + w . A(q) q' + q' . M q' / 2
    angular momentum   I(q) w + A(q) q'
    momenta of q       M q' + A(q)^T w

and its equations of motion, with f the elastic force and Q the loads, are

    M q'' + A(q)^T w' - 2 G(w) q' - c(q, w) + f(q) = Q              G skew: Coriolis
    d/dt (R (I(q) w + A(q) q')) = moment of the loads                A^T w': Euler; c: centrifugal

Shabana, Dynamics of Multibody Systems, chapter 5. Terzopoulos and Witkin, Physically based models
with rigid and deformable components (IEEE Computer Graphics and Applications 8(6), 1988), split
deformable bodies in this way for animation.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.frame import PAIRS, FloatingFrame
from fenics_defo.runtime.floating.products import times
from fenics_defo.runtime.floating.rotations import LEVI_CIVITA

Array = NDArray[np.float64]

_EYE = np.eye(3)
# tr(P) 1 - P of a matrix (9,) as a matrix (9, 9).
_INERTIA = np.outer(_EYE, _EYE) - np.eye(9)
# 2 w_k tr(W) - w_a (W_ka + W_ak) of moments (9, r), as (3, 27): w times it is (3, 9).
_SLOPE = (
    2.0 * np.einsum("lk,ab->lkab", _EYE, _EYE)
    - np.einsum("lb,ka->lkab", _EYE, _EYE)
    - np.einsum("la,kb->lkab", _EYE, _EYE)
).reshape(3, 27)


@dataclass(frozen=True, slots=True, eq=False)
class InertiaAtShape:
    """The inertia at coordinates q (..., r).

    Args:
        moments: W_abi = int rho (X + U q)_a U_bi dV (..., 9, r), pairs (a, b) in rows.
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
        return (spin @ _SLOPE).reshape(*spin.shape, 9) @ self.moments


class Inertia:
    """Evaluates the inertia of a frame at any shape and spin; all arrays take leading axes.

    Args:
        frame: the integrals of mass.
        coupled: False neglects the inertial coupling: A, G and c vanish, I stays that at rest.
    """

    def __init__(self, frame: FloatingFrame, *, coupled: bool = True) -> None:
        r = frame.size
        blocks, linear = np.zeros((3, 3, r, r)), np.zeros((3, 3, r))
        if coupled:
            linear += frame.linear
            for (a, b), block in zip(PAIRS, frame.quadratic, strict=True):
                blocks[a, b], blocks[b, a] = block, block.T
        #: M (r, r).
        self.mass: Array = frame.shape_mass
        # Moments of the places (X, U) by the places: bilinear in (1, q).
        table = np.empty((r + 1, 3, 3, r + 1))
        table[0, :, :, 0], table[0, :, :, 1:] = frame.second_moment, linear
        table[1:, :, :, 0], table[1:, :, :, 1:] = linear.T, blocks.transpose(2, 0, 1, 3)
        self._table = table.reshape(r + 1, 9 * (r + 1))
        gyro = np.stack([blocks[b, c] - blocks[c, b] for b, c in ((1, 2), (2, 0), (0, 1))])
        self._gyro = np.ascontiguousarray(gyro.reshape(3 * r, r).T)
        self._gyro_rows = gyro.reshape(3, r * r)
        self._squares = -blocks.reshape(9, r * r)
        if coupled:
            self._squares[::4] += self.mass.ravel()

    def at(self, q: Array) -> InertiaAtShape:
        """The inertia at coordinates q (..., r)."""
        leading, r = q.shape[:-1], q.shape[-1]
        place = np.empty((*leading, r + 1))
        place[..., 0], place[..., 1:] = 1.0, q
        every = (place @ self._table).reshape(*leading, 9, r + 1)
        second = times(every, place)
        moments = every[..., 1:]
        inertia = (second @ _INERTIA).reshape(*leading, 3, 3)
        return InertiaAtShape(moments, inertia, LEVI_CIVITA @ moments)

    def gyroscopic_rows(self, rates: Array) -> Array:
        """G_k q' (..., 3, r) for unit spins about the axes; G(w) q' is their sum by w."""
        return (rates @ self._gyro).reshape(*rates.shape[:-1], 3, rates.shape[-1])

    def turning(self, spin: Array) -> tuple[Array, Array]:
        """G(w), skew, and the slope dc/dq = w² M - w_a w_b N_ab, both (..., r, r)."""
        shape = (*spin.shape[:-1], *self.mass.shape)
        pairs = (spin[..., :, None] * spin[..., None, :]).reshape(*spin.shape[:-1], 9)
        return (spin @ self._gyro_rows).reshape(shape), (pairs @ self._squares).reshape(shape)
