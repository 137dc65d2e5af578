"""One mode with Rayleigh damping, against the differential equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_defo.beams import BeamError, DampedOscillator, rayleigh_oscillator


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.7, 1.0, 1.0 + 1e-9, 3.0])
def test_free_motion_solves_its_equation(ratio):
    omega, times = 3.0, np.linspace(0.0, 4.0, 9)
    exact = solve_ivp(
        lambda t, q: [q[1], -(omega**2) * q[0] - 2.0 * ratio * omega * q[1]],
        (0.0, 4.0),
        [0.7, -1.1],
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13,
    ).y[0]
    motion = DampedOscillator(omega, ratio).free_motion(times, start=0.7, velocity=-1.1)
    np.testing.assert_allclose(motion, exact, atol=1e-8)


def test_period_and_decrement_are_those_of_the_motion():
    oscillator = rayleigh_oscillator(frequency=2.0, mass_damping=0.8, stiffness_damping=0.01)
    omega = 4.0 * np.pi
    assert oscillator.decay_rate == pytest.approx(0.5 * (0.8 + 0.01 * omega**2))
    # Maxima of a motion that starts at rest are one period apart.
    period = oscillator.period
    first, second = oscillator.free_motion([0.0, period], start=1.0)
    assert np.log(first / second) == pytest.approx(oscillator.logarithmic_decrement)
    around = oscillator.free_motion(period + np.array([-1e-3, 0.0, 1e-3]), start=1.0)
    assert around.argmax() == 1
    assert second / first == pytest.approx(1.0 - oscillator.decay_over(period))


def test_no_damping_and_too_much():
    free = rayleigh_oscillator(frequency=5.0)
    assert (free.period, free.decay_rate, free.decay_over(3.0)) == (pytest.approx(0.2), 0.0, 0.0)
    heavy = rayleigh_oscillator(frequency=5.0, mass_damping=100.0)
    assert heavy.period == np.inf
    assert heavy.logarithmic_decrement == np.inf
    # No overflow long after the motion has died.
    assert heavy.free_motion(1e6, start=1.0) == 0.0
    with pytest.raises(BeamError, match="mass_damping must not be negative"):
        rayleigh_oscillator(frequency=5.0, mass_damping=-1.0)
    with pytest.raises(BeamError, match="stiffness_damping"):
        rayleigh_oscillator(frequency=5.0, stiffness_damping=float("nan"))
    with pytest.raises(BeamError, match="frequency"):
        rayleigh_oscillator(frequency=0.0)
