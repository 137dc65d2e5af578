"""Large deflections of a cantilever."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_defo.beams import (
    BeamError,
    CircularSection,
    RectangularSection,
    cantilever_tip,
    elastica_end_force,
    elastica_end_moment,
)

SECTION = RectangularSection(0.02, 0.01)
BEAM = {"length": 1.5, "section": SECTION, "young": 2.0e9}
UNIT = BEAM["young"] * SECTION.second_moment_y / BEAM["length"] ** 2  # force of load 1


def shoot(load):
    """x / L, y / L, theta of the tip by integrating the equilibrium equations of the curve."""

    def states(slope):
        return solve_ivp(
            lambda s, u: [u[1], -load * np.cos(u[0]), np.cos(u[0]), np.sin(u[0])],
            (0.0, 1.0),
            [0.0, slope, 0.0, 0.0],
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        ).y[:, -1]

    # The base curvature is load * x_tip, hence at most the load; and at most sqrt(2 load).
    slope = brentq(lambda k: states(k)[1], 0.0, min(load, np.sqrt(2.0 * load)), xtol=1e-14)
    tip = states(slope)
    return tip[2], tip[3], tip[0]


@pytest.mark.parametrize("load", [0.01, 0.5, 3.0, 12.0])
def test_end_force_matches_shooting(load):
    tip = elastica_end_force(**BEAM, force=load * UNIT)
    x, y, rotation = shoot(load)
    assert (tip.x / 1.5, tip.y / 1.5, tip.rotation) == pytest.approx((x, y, rotation), abs=1e-9)


@pytest.mark.parametrize(
    # Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145: (L - x) / L, y / L, rotation.
    ("load", "shortening", "height", "rotation"),
    [
        (1, 0.05643, 0.30172, 0.46135),
        (2, 0.16064, 0.49346, 0.78175),
        (10, 0.55500, 0.81061, 1.43029),
    ],
)
def test_end_force_matches_the_published_table(load, shortening, height, rotation):
    tip = elastica_end_force(**BEAM, force=load * UNIT)
    assert 1.0 - tip.x / 1.5 == pytest.approx(shortening, abs=1e-5)
    assert tip.y / 1.5 == pytest.approx(height, abs=1e-5)
    assert tip.rotation == pytest.approx(rotation, abs=1e-5)


def test_small_forces_give_linear_theory_with_order_two():
    errors = []
    for load in (0.1, 0.05, 0.025):
        tip = elastica_end_force(**BEAM, force=load * UNIT)
        linear = cantilever_tip(**BEAM, poisson=0.3, force=load * UNIT, theory="euler-bernoulli")
        errors.append([1.0 - tip.y / linear.deflection, 1.0 - tip.rotation / linear.rotation])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.02)
    tiny = elastica_end_force(**BEAM, force=1e-12 * UNIT)
    assert tiny.y == pytest.approx(1.5e-12 / 3.0, rel=1e-12)
    assert tiny.rotation == pytest.approx(0.5e-12, rel=1e-12)


@given(load=st.floats(1e-8, 1e5))
def test_the_curve_bends_up_within_its_length_and_is_odd_in_the_force(load):
    tip = elastica_end_force(**BEAM, force=load * UNIT)
    assert np.hypot(tip.x, tip.y) <= 1.5 * (1.0 + 1e-14)
    assert 0.0 < tip.rotation <= 0.5 * np.pi
    # Moment balance of the clamp against the first integral of the elastica.
    assert (tip.x / 1.5) ** 2 * load == pytest.approx(2.0 * np.sin(tip.rotation), rel=1e-12)
    pushed = elastica_end_force(**BEAM, force=-load * UNIT)
    assert (pushed.x, pushed.y, pushed.rotation) == (tip.x, -tip.y, -tip.rotation)


def test_a_huge_force_pulls_the_beam_straight():
    # All but a boundary layer of length sqrt(E I / F) stands upright.
    gaps = [1.0 - elastica_end_force(**BEAM, force=f * UNIT).y / 1.5 for f in (1e3, 4e3, 1.6e4)]
    np.testing.assert_allclose(np.array(gaps[:-1]) / gaps[1:], 2.0, rtol=1e-6)


@pytest.mark.parametrize("turns", [0.25, 0.5, 1.0, 2.0])
def test_an_end_moment_rolls_the_beam_into_circles(turns):
    angle = 2.0 * np.pi * turns
    radius = 1.5 / angle
    tip = elastica_end_moment(**BEAM, moment=BEAM["young"] * SECTION.second_moment_y / radius)
    assert tip.rotation == pytest.approx(angle)
    assert tip.x == pytest.approx(radius * np.sin(angle), abs=1e-14)
    assert tip.y == pytest.approx(radius * (1.0 - np.cos(angle)), abs=1e-14)


@given(moment=st.floats(1e-9, 1e-3))
def test_a_small_end_moment_gives_linear_theory(moment):
    tip = elastica_end_moment(**BEAM, moment=moment)
    linear = cantilever_tip(**BEAM, poisson=0.3, moment=moment, theory="euler-bernoulli")
    assert tip.y == pytest.approx(linear.deflection, rel=1e-6, abs=0.0)
    assert tip.rotation == pytest.approx(linear.rotation, rel=1e-12, abs=0.0)


def test_no_load_no_motion_and_refusals():
    for tip in (elastica_end_force(**BEAM, force=0.0), elastica_end_moment(**BEAM, moment=0.0)):
        assert (tip.x, tip.y, tip.rotation) == (1.5, 0.0, 0.0)
    stiff = elastica_end_force(**BEAM, force=UNIT, direction="y")
    assert stiff.y < elastica_end_force(**BEAM, force=UNIT).y
    with pytest.raises(BeamError, match="at most 100000"):
        elastica_end_force(**BEAM, force=2e5 * UNIT)
    with pytest.raises(BeamError, match="force"):
        elastica_end_force(**BEAM, force=float("nan"))
    with pytest.raises(BeamError, match="moment"):
        elastica_end_moment(length=1.0, section=CircularSection(1.0), young=1.0, moment=np.inf)
