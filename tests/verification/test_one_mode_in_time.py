"""One mode of a linear body: each integrator against its own recurrence, and against theory."""

import numpy as np
import pytest
from bodies import Array
from motions import EXPLICIT, INTEGRATORS, ORDERS, bar, halving, modal_motion, one_mode

from fenics_defo.analysis import BackwardEuler, CentralDifferences, ImplicitNewmark, SymplecticEuler
from fenics_defo.beams import rayleigh_oscillator

each_integrator = pytest.mark.parametrize("name", INTEGRATORS)


def newmark_recurrence(method: ImplicitNewmark, omega: float, h: float, c: float) -> Array:
    """(q, q', q'') after a step from those before it, for q'' + c q' + omega² q = 0."""
    beta, gamma = method.beta, method.gamma
    position = np.array([1.0, h, (0.5 - beta) * h**2])
    rate = np.array([0.0, 1.0, (1.0 - gamma) * h])
    bent = -(c * rate + omega**2 * position) / (1.0 + gamma * h * c + beta * (h * omega) ** 2)
    return np.array([position + beta * h**2 * bent, rate + gamma * h * bent, bent])


def backward_euler_recurrence(omega: float, h: float, c: float) -> Array:
    """The same, from the velocity at the end of the step alone."""
    rate = np.array([-h * omega**2, 1.0, 0.0]) / (1.0 + h * c + (h * omega) ** 2)
    position = np.array([1.0, 0.0, 0.0]) + h * rate
    return np.array([position, rate, (rate - np.array([0.0, 1.0, 0.0])) / h])


METHODS = {
    "average acceleration": ImplicitNewmark(),
    "linear acceleration, nearly": ImplicitNewmark(beta=0.26, gamma=0.5),
    "numerical damping": ImplicitNewmark(beta=0.49, gamma=0.9),
    "backward Euler": BackwardEuler(),
}


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("damping", [(0.0, 0.0), (0.4, 0.003)])
@pytest.mark.parametrize("phase", [0.2, 30.0])
def test_implicit_recurrence(
    method: ImplicitNewmark | BackwardEuler, damping: tuple[float, float], phase: float
) -> None:
    """To round-off, from a fifth of a radian a step to five periods a step."""
    omega = one_mode(bar(), 2, lumped=False).omega
    h, c = phase / omega, damping[0] + damping[1] * omega**2
    _, q, v = modal_motion(method, number=2, step=h, count=12, damping=damping, velocity=3.0)
    if isinstance(method, ImplicitNewmark):
        matrix = newmark_recurrence(method, omega, h, c)
    else:
        matrix = backward_euler_recurrence(omega, h, c)
    expected = [np.array([1.0, 3.0, -3.0 * c - omega**2])]
    for _ in range(12):
        expected.append(matrix @ expected[-1])
    found = np.stack([q, v / omega], axis=1)
    assert found == pytest.approx(np.array(expected)[:, :2] / [1.0, omega], abs=1e-8)


def test_central_differences_recurrence() -> None:
    """q'' - 2 q' + q = -h² omega² q', started from rest: cos of the angle 2 asin(h omega / 2)."""
    omega = one_mode(bar(), 3, lumped=True).omega
    step = 0.2 / omega
    mode, q, v = modal_motion(CentralDifferences(), number=3, step=step, count=40)
    angle = 2.0 * np.arcsin(0.5 * step * mode.omega) * np.arange(41)
    assert q == pytest.approx(np.cos(angle), abs=1e-9)
    assert v / mode.omega == pytest.approx(-np.sin(angle) * np.sqrt(1.0 - 0.1**2), abs=1e-9)


def test_symplectic_euler_walks_through_the_same_places() -> None:
    """Displacements obey the same recurrence, and q v-products keep the method's own invariant.

    v² + omega² q² - h omega² q v is constant: Hairer, Lubich and Wanner, Geometric Numerical
    Integration (2006), section IX.
    """
    omega = one_mode(bar(), 3, lumped=True).omega
    step = 0.2 / omega
    mode, q, v = modal_motion(SymplecticEuler(), number=3, step=step, count=40, velocity=2.0)
    second = q[2:] - 2.0 * q[1:-1] + q[:-2]
    assert second == pytest.approx(-((step * mode.omega) ** 2) * q[1:-1], abs=1e-9)
    energy = (v / mode.omega) ** 2 + q**2
    invariant = np.array([energy - 0.2 * q * v / mode.omega, energy + 0.2 * q * v / mode.omega])
    assert invariant.std(axis=1).min() < 1e-9
    assert energy.std() > 1e-3


@each_integrator
def test_period_and_decay(name: str) -> None:
    """Order of convergence to the damped oscillator's closed form, damping of both kinds."""
    mode = one_mode(bar(), 1, lumped=name in EXPLICIT)
    frequency = mode.omega / (2.0 * np.pi)
    # A twentieth of critical damping, half by mass and half by stiffness.
    damping = (0.05 * mode.omega, 0.05 / mode.omega)
    theory = rayleigh_oscillator(
        frequency=frequency, mass_damping=damping[0], stiffness_damping=damping[1]
    )
    time = 1.3 * theory.period
    exact = theory.free_motion(time, start=1.0)

    def error(count: int) -> float:
        _, q, _ = modal_motion(
            INTEGRATORS[name], number=1, step=time / count, count=count, damping=damping
        )
        return abs(float(q[-1] - exact))

    counts = (320, 640) if name in EXPLICIT else (40, 80)
    # The explicit methods take the velocity of the stiffness part from half a step before.
    order = 1.0 if name in EXPLICIT else ORDERS[name]
    assert halving(error, counts)[-1] == pytest.approx(order, abs=0.25)


@each_integrator
def test_period_without_damping(name: str) -> None:
    """Order of convergence of the displacement to the cosine."""
    mode = one_mode(bar(), 1, lumped=name in EXPLICIT)
    time = 0.8 * 2.0 * np.pi / mode.omega

    def error(count: int) -> float:
        _, q, _ = modal_motion(INTEGRATORS[name], number=1, step=time / count, count=count)
        return abs(float(q[-1] - np.cos(mode.omega * time)))

    counts = (160, 320) if name in EXPLICIT else (20, 40)
    assert halving(error, counts)[-1] == pytest.approx(ORDERS[name], abs=0.15)
