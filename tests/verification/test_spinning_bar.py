"""Spinning bars: the stretch of a steady spin, and vibrations seen from a turning frame."""

from typing import Any

import numpy as np
import pytest
from bodies import Array, box, orders
from flying_bodies import Flyer, deformations, linear_flyer

from fenics_defo.analysis import linear_modes
from fenics_defo.energy import LinearElastic
from fenics_defo.fem import Solid
from fenics_defo.runtime import FloatingBody

YOUNG, DENSITY, LENGTH = 2.0e4, 1000.0, 1.0


def bar(cells: int) -> Flyer:
    """Without lateral contraction, so that it is a rod along each axis; all its shapes."""
    law = LinearElastic(young=YOUNG, poisson=0.0, density=DENSITY)
    solid = Solid(box("hexahedron", (cells, 1, 1), (LENGTH, 0.1, 0.1)), law)
    return linear_flyer(solid, deformations(solid)[1])


def tip(spin: float) -> float:
    """Displacement of the end of a rod that spins about its middle.

    E u'' + rho w² (x + u) = 0 with u(0) = 0 and u'(L/2) = 0: u = sin(k x) / (k cos(k L/2)) - x.
    """
    k = spin * np.sqrt(DENSITY / YOUNG)
    return float(np.tan(0.5 * k * LENGTH) / k - 0.5 * LENGTH)


def steady(model: Flyer, spin: float) -> Array:
    """Coordinates at which the elastic and the centrifugal force are equal: a static problem."""
    frame = model.frame
    # The centrifugal force of a spin about z is that of the masses at their distance from it.
    blocks = frame.quadratic[0] + frame.quadratic[1]
    rest = frame.linear[0, 0] + frame.linear[1, 1]
    stiffness: Array = model.law.matrix
    return np.asarray(np.linalg.solve(stiffness - spin**2 * blocks, spin**2 * rest))


def end_displacement(body: FloatingBody) -> float:
    """Of the bar's end at x = 1, along the bar."""
    inside = (body.world_points() - body.position) @ body.rotation
    return float(inside[np.argmax(inside[:, 0]), 0]) - 0.5 * LENGTH


def test_steady_stretch() -> None:
    """It stays what it is, and tends to the closed form as the cells get smaller."""
    spin, errors = 4.0, []
    for cells in (4, 8, 16):
        model = bar(cells)
        q = steady(model, spin)
        body = FloatingBody(model, step=0.05, angular_velocity=(0.0, 0.0, spin), q=q)
        for _ in range(10):
            body.advance()
        assert body.q == pytest.approx(q, abs=1e-11 * np.abs(q).max())
        assert body.angular_velocity == pytest.approx([0.0, 0.0, spin], abs=1e-11)
        errors.append(end_displacement(body) - tip(spin))
    assert tip(spin) > 0.03
    assert abs(errors[-1]) < 1e-3 * tip(spin)
    assert orders(errors) == pytest.approx(2.0, abs=0.1)


def test_a_damped_bar_comes_to_the_steady_stretch() -> None:
    """From its rest shape. As it grows longer it turns more slowly, with the same momentum."""
    model = bar(6)
    body = FloatingBody(
        model, step=0.05, damping=(0.0, 0.05), newton=2, angular_velocity=(0.0, 0.0, 4.0)
    )
    before = body.momentum()[1]
    for _ in range(400):
        body.advance()
    spin = float(body.angular_velocity[2])
    assert spin < 3.95
    assert body.q == pytest.approx(steady(model, spin), abs=1e-6)
    assert end_displacement(body) == pytest.approx(tip(spin), rel=0.01)
    assert body.momentum()[1] == pytest.approx(before, abs=1e-12 * before[2])


def test_without_coupling_a_spin_stretches_nothing() -> None:
    body = FloatingBody(bar(3), step=0.05, coupling="none", angular_velocity=(0.0, 0.0, 4.0))
    for _ in range(20):
        body.advance()
    assert end_displacement(body) == pytest.approx(0.0, abs=1e-14)


def slender() -> tuple[Flyer, float]:
    """The lowest pair of bending modes of a square bar along x, and their ω [rad/s]."""
    law = LinearElastic(young=2.0e7, poisson=0.0, density=DENSITY)
    solid = Solid(box("hexahedron", (24, 1, 1), (LENGTH, 0.03, 0.03)), law)
    modes = linear_modes(solid, 8)
    shapes = modes.shapes[modes.rigid_modes :][:2]
    return linear_flyer(solid, shapes), float(modes.omega[modes.rigid_modes])


def vibration(*, spin: float, rate: Any, coupling: Any) -> tuple[float, Array, Array]:
    """ω, times (k,) and the pair's coordinates (k, 2) of a spinning bar, from q = (a, 0).

    Args:
        spin: about the bar's axis, in units of ω.
        rate: (ω, spin [rad/s], sense of the second mode) -> initial rates, in units of a.
        coupling: of the floating body.
    """
    model, omega = slender()
    turn = spin * omega
    gyro = model.frame.quadratic[3] - model.frame.quadratic[3].T
    sense = float(np.sign(gyro[0, 1]))
    small = 1e-4
    body = FloatingBody(
        model,
        step=2.0 * np.pi / omega / 80,
        coupling=coupling,
        angular_velocity=(turn, 0.0, 0.0),
        q=(small, 0.0),
        v=small * np.asarray(rate(omega, turn, sense)),
    )
    times, found = [0.0], [body.q]
    for _ in range(240):
        body.advance()
        times.append(body.time)
        found.append(body.q)
    q = np.array(found) / small
    q[:, 1] *= sense
    return omega, np.array(times), q


@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_whirling_frequencies(forward: float) -> None:
    """In the frame a wave that runs with the spin has ω - Ω, one against it ω + Ω."""
    share = 0.3
    omega, times, q = vibration(
        spin=share,
        rate=lambda w, turn, sense: (0.0, forward * (w - forward * turn) * sense),
        coupling="full",
    )
    phase = np.unwrap(np.arctan2(q[:, 1], q[:, 0]))
    slope = np.polyfit(times, phase, 1)[0]
    assert slope == pytest.approx(forward * omega * (1.0 - forward * share), rel=0.01)
    assert np.linalg.norm(q, axis=1) == pytest.approx(1.0, abs=0.05)


def test_the_plane_of_vibration_stays_in_the_world() -> None:
    """As Foucault's pendulum: in the frame it turns backwards. Without coupling it is dragged."""
    share = 0.1

    def still(w: float, turn: float, sense: float) -> tuple[float, float]:
        return 0.0, -turn * sense

    omega, times, q = vibration(spin=share, rate=still, coupling="full")
    swing = np.cos(omega * times)
    angle = share * omega * times
    expected = swing[:, None] * np.stack([np.cos(angle), -np.sin(angle)], axis=1)
    assert np.abs(q - expected).max() < 0.05
    _, _, dragged = vibration(spin=share, rate=still, coupling="none")
    assert np.abs(dragged - expected).max() > 0.5
