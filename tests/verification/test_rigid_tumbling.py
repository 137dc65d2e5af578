"""A rigid body that nothing turns, against Euler's closed forms."""

from typing import Any

import numpy as np
import pytest
from bodies import Array
from flying_bodies import Flyer, MatrixLaw
from scipy.special import ellipj

from fenics_defo.runtime import FloatingBody, FloatingFrame

# Principal moments of the second-moment tensor and, from them, of inertia, ascending.
SECOND = np.array([5.0, 3.0, 1.0])
INERTIA = SECOND.sum() - SECOND


def rigid(second: Array = SECOND) -> Flyer:
    """A body without shapes."""
    frame = FloatingFrame(
        mass=2.0,
        centre=np.zeros(3),
        second_moment=np.diag(second),
        mean=np.zeros((3, 0)),
        linear=np.zeros((3, 3, 0)),
        quadratic=np.zeros((6, 0, 0)),
    )
    return Flyer(MatrixLaw(np.zeros((0, 0))), frame, np.zeros((1, 3)), np.zeros((1, 3, 0)))


def spin_of(body: FloatingBody) -> Array:
    """Angular velocity in the body's axes."""
    return body.rotation.T @ body.angular_velocity


def euler(time: float, energy: float, square: float) -> Array:
    """Angular velocity (3,) of an asymmetric top by Jacobi's functions, for L² > 2 E I_2.

    Landau and Lifshitz, Mechanics, section 37.
    """
    a, b, c = INERTIA
    rest, more = 2.0 * energy * c - square, square - 2.0 * energy * a
    rate = np.sqrt((c - b) * more / (a * b * c))
    sn, cn, dn, _ = ellipj(rate * time, (b - a) * rest / ((c - b) * more))
    sizes = np.sqrt([rest / (a * (c - a)), rest / (b * (c - b)), more / (c * (c - a))])
    return np.array([sizes[0] * cn, sizes[1] * sn, sizes[2] * dn])


def test_asymmetric_top() -> None:
    """Its angular velocity is Euler's; the error falls with the square of the step."""
    energy, square = 8.0, 110.0
    start = euler(0.0, energy, square)
    assert 0.5 * start @ (INERTIA * start) == pytest.approx(energy)
    errors = []
    for count in (200, 400, 800):
        body = FloatingBody(rigid(), step=8.0 / count, angular_velocity=start)
        for _ in range(count):
            body.advance()
        errors.append(np.abs(spin_of(body) - euler(8.0, energy, square)).max())
    assert errors[-1] < 2e-4 * np.abs(start).max()
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("newton", [1, None])
def test_energy_and_momentum_of_a_top(newton: int | None) -> None:
    """Momentum to round-off; energy without drift, for the step is symmetric in time."""
    body = FloatingBody(rigid(), step=0.1, newton=newton, angular_velocity=(1.0, 1.3, 0.2))
    momentum, energy = body.momentum()[1], float(body.energies.kinetic)
    energies = []
    for _ in range(1000):
        body.advance()
        energies.append(float(body.energies.kinetic))
    assert body.momentum()[1] == pytest.approx(momentum, rel=1e-13)
    error = np.array(energies) / energy - 1.0
    assert np.abs(error).max() < 0.01
    assert abs(error[500:].mean() - error[:500].mean()) < 1e-4


def test_intermediate_axis_flips_and_the_others_do_not() -> None:
    """The tennis racket: a slight push turns a spin about the middle axis over, again and again."""

    def flips(axis: int) -> int:
        start = np.full(3, 1e-3)
        start[axis] = 3.0
        body, signs = FloatingBody(rigid(), step=0.1, angular_velocity=start), []
        for _ in range(450):
            body.advance()
            signs.append(np.sign(spin_of(body)[axis]))
        return int(np.count_nonzero(np.diff(signs)))

    assert flips(0) == 0
    assert flips(2) == 0
    assert flips(1) >= 3


def test_symmetric_top_precesses() -> None:
    """Spin and angular momentum turn about the axis of symmetry at (I_3 - I_1) / I_1 w_3."""
    second = np.array([2.0, 2.0, 1.0])
    moments = second.sum() - second
    start = np.array([0.5, 0.0, 2.0])
    rate = (moments[2] - moments[0]) / moments[0] * start[2]
    body = FloatingBody(rigid(second), step=0.005, angular_velocity=start)
    turned = np.linalg.norm(moments * start) / moments[0]
    for _ in range(400):
        body.advance()
    found = spin_of(body)
    expected = [0.5 * np.cos(2.0 * rate), 0.5 * np.sin(2.0 * rate), 2.0]
    assert found == pytest.approx(expected, abs=1e-4)
    # Seen from outside, the axis itself precesses about L at L / I_1.
    axis, fixed = body.rotation[:, 2], body.momentum()[1]
    fixed /= np.linalg.norm(fixed)
    flat = axis - (axis @ fixed) * fixed
    before = np.array([0.0, 0.0, 1.0]) - fixed[2] * fixed
    angle = np.arctan2(fixed @ np.cross(before, flat), before @ flat)
    assert angle == pytest.approx(np.angle(np.exp(1j * turned * 2.0)), abs=1e-3)


def test_a_steady_spin_is_exact() -> None:
    """About a principal axis, with a fifth of a turn a step."""
    spin = np.array([0.0, 0.0, 12.0])
    body = FloatingBody(rigid(), step=0.1, angular_velocity=spin, velocity=(1.0, 0.0, -2.0))
    for _ in range(50):
        body.advance()
    angle = 12.0 * 5.0
    assert body.rotation[0, 0] == pytest.approx(np.cos(angle), abs=1e-12)
    assert body.rotation[1, 0] == pytest.approx(np.sin(angle), abs=1e-12)
    assert body.position == pytest.approx([5.0, 0.0, -10.0], rel=1e-13)


def test_a_rigid_body_has_no_use_for_coupling() -> None:
    options: dict[str, Any] = {"step": 0.05, "angular_velocity": (0.3, 2.0, 0.1)}
    full, none = (FloatingBody(rigid(), coupling=c, **options) for c in ("full", "none"))
    for _ in range(100):
        full.advance()
        none.advance()
    assert np.array_equal(full.rotation, none.rotation)
