"""Exact motion of damped oscillators over a time step, for any damping and any step."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Terms of the series: the n-th is below 2.5^n / (n + 1)! with arguments as small as these.
_TERMS = 26
_SMALL_DAMPING, _SMALL_STIFFNESS = 2.0, 1.0


@dataclass(frozen=True, slots=True)
class ModalResponse:
    """Motion of z'' + c z' + k z = p over a step h, each array (r,).

    With p = p₀ + (p₁ - p₀) t / h, from z, v at its start the step ends at

        z' = z_of_z z + z_of_v v + z_of_load p₀ + z_of_ramp (p₁ - p₀)
        v' = v_of_z z + v_of_v v + v_of_load p₀ + v_of_ramp (p₁ - p₀)
    """

    z_of_z: Array
    z_of_v: Array
    v_of_z: Array
    v_of_v: Array
    z_of_load: Array
    v_of_load: Array
    z_of_ramp: Array
    v_of_ramp: Array


def modal_response(stiffness: Array, damping: Array, step: float) -> ModalResponse:
    """Exact response of oscillators, unstable ones (k < 0) included.

    With the roots s of s² + c s + k = 0, all of it are divided differences of the exponential:
    S = h exp[s₁h, s₂h], the velocity's effect, and the integrals of S from 0 to h,
    P = h² exp[0, s₁h, s₂h] and R = h³ exp[0, 0, s₁h, s₂h]. They are summed as a series where the
    arguments are small, taken from the two real roots where these lie apart, and from the
    equation of motion elsewhere, so that nothing cancels.

    Args:
        stiffness: k = ω² (r,) [1/s²].
        damping: c (r,) [1/s], not negative.
        step: h [s].

    References: McCurdy, Ng and Parlett, Math. Comp. 43(168), 1984, on divided differences of the
    exponential.
    """
    x, y = damping * step, stiffness * step**2
    gap = 0.25 * x**2 - y  # (s₁ - s₂)² h² / 4
    small = (x <= _SMALL_DAMPING) & (np.abs(y) <= _SMALL_STIFFNESS)
    real = ~small & (gap > 0.25)
    rest = ~small & ~real
    found = np.empty((5, x.size))
    for chosen, compute in ((small, _series), (real, _real_roots), (rest, _oscillation)):
        if chosen.any():
            found[:, chosen] = compute(x[chosen], y[chosen])
    stay, keep, one, two, three = found
    return ModalResponse(
        z_of_z=stay,
        z_of_v=step * one,
        v_of_z=-stiffness * step * one,
        v_of_v=keep,
        z_of_load=step**2 * two,
        v_of_load=step * one,
        z_of_ramp=step**2 * three,
        v_of_ramp=step * two,
    )


def _series(x: Array, y: Array) -> Array:
    """Rows z_of_z, v_of_v, S/h, P/h², R/h³ by powers: H_n = -x H_(n-1) - y H_(n-2)."""
    before, power = np.zeros_like(x), np.ones_like(x)
    sums, weight = np.zeros((3, x.size)), 1.0  # weight = 1 / n!
    for n in range(_TERMS):
        term = weight / (n + 1.0) * power
        for row in range(3):
            sums[row] += term
            term = term / (n + 2.0 + row)
        weight /= n + 1.0
        before, power = power, -x * power - y * before
    one, two, three = sums
    return np.array([1.0 - y * two, 1.0 - x * one - y * two, one, two, three])


def _real_roots(x: Array, y: Array) -> Array:
    """The same rows by two real roots apart from each other."""
    root = np.sqrt(0.25 * x**2 - y)
    second = -0.5 * x - root
    # The smaller root without cancellation; root > 0.5 and x >= 0 keep the divisor off zero.
    first = y / second
    width = first - second
    e1, e2 = np.exp(first), np.exp(second)
    stay = (first * e2 - second * e1) / width
    keep = (first * e1 - second * e2) / width
    rows = [(f(first) - f(second)) / width for f in (np.exp, _phi1, _phi2)]
    return np.array([stay, keep, *rows])


def _oscillation(x: Array, y: Array) -> Array:
    """The same rows by complex roots, or by real ones side by side, where y is not small."""
    gap = y - 0.25 * x**2
    angle = np.sqrt(np.abs(gap))
    decay = np.exp(-0.5 * x)
    near = np.where(gap < 0.0, np.cosh(np.minimum(angle, 1.0)), np.cos(angle))
    ratio = np.where(gap < 0.0, _sinhc(np.minimum(angle, 1.0)), np.sinc(angle / np.pi))
    one = decay * ratio
    stay = decay * near + 0.5 * x * one
    keep = decay * near - 0.5 * x * one
    two = (1.0 - stay) / y
    # Twice the integral of the equation of motion.
    three = (1.0 - one - x * two) / y
    return np.array([stay, keep, one, two, three])


def _sinhc(x: Array) -> Array:
    return np.divide(np.sinh(x), x, out=np.ones_like(x), where=x > 0.0)


def _phi1(x: Array) -> Array:
    """(eˣ - 1) / x."""
    return np.divide(np.expm1(x), x, out=np.ones_like(x), where=x != 0.0)


def _phi2(x: Array) -> Array:
    """(eˣ - 1 - x) / x²; by its series for small x."""
    close = np.abs(x) < 1.0
    safe = np.where(close, 1.0, x)
    far = (np.expm1(safe) - safe) / safe**2
    total, power = np.zeros_like(x), np.full_like(x, 0.5)
    for n in range(20):
        total += power
        power = power * np.where(close, x, 0.0) / (n + 3.0)
    return np.where(close, total, far)
