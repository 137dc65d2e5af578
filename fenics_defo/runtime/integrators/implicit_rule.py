"""Implicit methods as linear maps of the state, so that a step is one small matrix product."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplicitRule:
    """Velocity and acceleration at the end of a step as functions of the displacement there.

    v' = velocity_of_v v + velocity_of_a a + velocity_rate (q' - q)
    a' = acceleration_of_v v + acceleration_of_a a + acceleration_rate (q' - q)

    Args:
        velocity_rate: [1/s].
        acceleration_rate: [1/s²].
        velocity_of_v: [-].
        velocity_of_a: [s].
        acceleration_of_v: [1/s].
        acceleration_of_a: [-].
    """

    velocity_rate: float
    acceleration_rate: float
    velocity_of_v: float
    velocity_of_a: float
    acceleration_of_v: float
    acceleration_of_a: float


@dataclass(frozen=True, slots=True)
class Transitions:
    """The linear part of Newton's method with Rayleigh damping C = alpha M + beta K(q).

    At an iterate q_k the change d of q solves (s K + m M) d = g - f - M (a_k + alpha v_k)
    - beta K v_k, with s = 1 + beta R, m = A + alpha R, and the rates A of the acceleration and R of
    the velocity. The product with K is spared by solving for x = s (d + c v_k), c = beta / s:

        (K + mass_scale M) x = g - f - M y,   y = a_k + (alpha - c m) v_k.

    All that follows is linear in x, q, v and a, so that matrices (4, 4) take these rows to the rows
    q, v, a and y of the next iterate.

    Args:
        mass_scale: m / s [1/s²].
        first: matrices of a step's first iteration: [1 if it is the last one too, else 0].
        again: matrices of the others, likewise.
        start: rows q, v, a, y of rows x, q, v, a at the start of a step, without a change.
    """

    mass_scale: float
    first: tuple[Array, Array]
    again: tuple[Array, Array]
    start: Array


def transitions(rule: ImplicitRule, damping: tuple[float, float]) -> Transitions:
    """The matrices of a method for a damping (alpha [1/s], beta [s])."""
    alpha, beta = damping
    s = 1.0 + beta * rule.velocity_rate
    m = rule.acceleration_rate + alpha * rule.velocity_rate
    c = beta / s
    x, q, v, a = np.eye(4)
    # Velocity and acceleration where the displacement is still that at the start.
    still_v = rule.velocity_of_v * v + rule.velocity_of_a * a
    still_a = rule.acceleration_of_v * v + rule.acceleration_of_a * a

    def moved(v_k: Array, a_k: Array) -> Array:
        d = x / s - c * v_k
        return np.array([q + d, v_k + rule.velocity_rate * d, a_k + rule.acceleration_rate * d])

    def with_y(rows: Array, *, last: int) -> Array:
        end_v, end_a = rows[1], rows[2]
        if last:  # the next solve is the first of a step
            end_v, end_a = (
                rule.velocity_of_v * end_v + rule.velocity_of_a * end_a,
                rule.acceleration_of_v * end_v + rule.acceleration_of_a * end_a,
            )
        return np.ascontiguousarray(np.vstack([rows, end_a + (alpha - c * m) * end_v]))

    first, again = moved(still_v, still_a), moved(v, a)
    return Transitions(
        mass_scale=m / s,
        first=(with_y(first, last=0), with_y(first, last=1)),
        again=(with_y(again, last=0), with_y(again, last=1)),
        start=with_y(np.array([q, v, a]), last=1),
    )
