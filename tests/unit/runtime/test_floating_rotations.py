"""Rotation matrices, the exponential map and quaternions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mass_clouds import Array

from fenics_defo.runtime.floating import rotations

angles = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)
SIZES = (0.0, 1e-9, 1e-3, 0.0099, 0.0101, 1.0, 3.1415926, 5.0)


def test_skew_is_the_cross_product() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 5, 3))
    assert rotations.cross(a, b) == pytest.approx(np.cross(a, b), abs=1e-15)


@pytest.mark.parametrize("size", SIZES)
def test_exponential_by_halving(size: float) -> None:
    """exp(a) = exp(a / 2^k)^(2^k), and a turn so small is the start of the series."""
    angle = size * np.array([0.36, -0.48, 0.8])
    s = rotations.skew(angle / 2.0**12)
    expected = np.eye(3) + s + s @ s / 2.0 + s @ s @ s / 6.0 + s @ s @ s @ s / 24.0
    for _ in range(12):
        expected = expected @ expected
    assert rotations.exponential(angle)[0] == pytest.approx(expected, abs=1e-11)


@given(angles)
def test_exponential_is_a_rotation(angle: Array) -> None:
    turn = rotations.exponential(angle)[0]
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=4e-15)
    assert turn @ angle == pytest.approx(angle, abs=4e-15)
    assert rotations.exponential(-angle)[0] == pytest.approx(turn.T, abs=1e-15)


@pytest.mark.parametrize("size", SIZES)
def test_jacobian_is_the_derivative(size: float) -> None:
    """exp(a)^T exp(a + e d) = 1 + e skew(J d), by central differences."""
    angle, e = size * np.array([0.6, 0.64, -0.48]), 1e-5
    turn, jacobian = rotations.exponential(angle)
    for d in np.eye(3):
        ahead, behind = (rotations.exponential(angle + s * e * d)[0] for s in (1.0, -1.0))
        slope = turn.T @ (ahead - behind) / (2.0 * e)
        assert slope == pytest.approx(rotations.skew(jacobian @ d), abs=1e-9)


@given(angles)
def test_quaternions_there_and_back(angle: Array) -> None:
    turn = rotations.exponential(angle)[0]
    quaternion = rotations.to_quaternion(turn)
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=1e-15)
    assert quaternion[0] >= 0.0
    assert rotations.from_quaternion(quaternion) == pytest.approx(turn, abs=4e-15)


def test_quaternion_of_a_known_turn() -> None:
    quaternion = rotations.to_quaternion(rotations.exponential(np.array([0.0, 0.0, 0.5]))[0])
    assert quaternion == pytest.approx([np.cos(0.25), 0.0, 0.0, np.sin(0.25)], abs=1e-15)
    half_turns = rotations.exponential(np.pi * np.eye(3))[0]
    assert np.abs(rotations.to_quaternion(half_turns)[:, 1:]) == pytest.approx(np.eye(3), abs=1e-15)


def test_round_off_is_taken_out() -> None:
    turn = rotations.exponential(np.array([0.3, -1.0, 0.7]))[0]
    spoilt = turn + 1e-6 * np.random.default_rng(1).normal(size=(3, 3))
    mended = rotations.orthonormalised(spoilt)
    assert np.abs(mended @ mended.T - np.eye(3)).max() < 1e-10
    assert np.abs(mended - turn).max() < 1e-5
