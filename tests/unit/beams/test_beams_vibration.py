"""Uniform beams: Euler-Bernoulli, Timoshenko, extension and torsion."""

import itertools

import numpy as np
import pytest
from beam_models import ritz_timoshenko
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo.beams import (
    BeamError,
    CircularSection,
    RectangularSection,
    Segment,
    TubeSection,
    axial_frequencies,
    euler_bernoulli_frequencies,
    timoshenko_frequencies,
    torsional_frequencies,
)
from fenics_defo.beams.stepped import beam_piece
from fenics_defo.beams.supports import beam_supports
from fenics_defo.errors import MaterialError

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7800.0}
SLENDER = {"young": 2.1e11, "density": 7800.0}
BOX = RectangularSection(0.05, 0.04)
SUPPORTS = ["-".join(pair) for pair in itertools.product(("clamped", "pinned", "free"), repeat=2)]
ALL_SUPPORTS = [*SUPPORTS, "clamped-sliding", "sliding-sliding", "pinned-sliding", "sliding-free"]


def cut_off(section, *, young, poisson, density, direction="z"):
    inertia = section.second_moment_y if direction == "z" else section.second_moment_z
    kappa = section.shear_coefficient(poisson)
    shear = kappa * young / (2.0 + 2.0 * poisson) * section.area
    return np.sqrt(shear / (density * inertia)) / (2.0 * np.pi)


@pytest.mark.parametrize("supports", ALL_SUPPORTS)
def test_timoshenko_agrees_with_a_ritz_basis_below_and_above_the_cut_off(supports):
    # So stubby that a third of these frequencies lie above the cut-off.
    beam = {"length": 0.2, "section": BOX, **STEEL}
    found = timoshenko_frequencies(**beam, count=16, supports=supports)
    ends = beam_supports(supports)
    piece = beam_piece(Segment(**beam), direction="z", theory="timoshenko", shear="cowper")
    ritz = ritz_timoshenko(piece, ends.held, degree=48)[ends.rigid :][:16]
    np.testing.assert_allclose(found, ritz, rtol=1e-8)
    assert found[3] < cut_off(BOX, **STEEL) < found[-1]


@pytest.mark.parametrize("length", [0.1, 0.5, 5.0])
def test_pinned_timoshenko_has_both_branches_and_the_pure_shear_mode(length):
    found = timoshenko_frequencies(
        length=length, section=BOX, **STEEL, count=25, supports="pinned-pinned"
    )
    young, density = STEEL["young"], STEEL["density"]
    rigidity = BOX.shear_coefficient(0.3) * young / 2.6
    k2 = (np.arange(1, 60) * np.pi / length) ** 2
    r2 = BOX.second_moment_y / BOX.area
    half = 0.5 * (rigidity / (density * r2) + k2 * (rigidity + young) / density)
    root = np.sqrt(half**2 - k2**2 * rigidity * young / density**2)
    branches = np.concatenate([k2**2 * rigidity * young / density**2 / (half + root), half + root])
    expected = np.sort(np.append(np.sqrt(branches) / (2.0 * np.pi), cut_off(BOX, **STEEL)))
    np.testing.assert_allclose(found, expected[:25], rtol=1e-8)


@pytest.mark.parametrize("supports", SUPPORTS)
def test_timoshenko_tends_to_euler_bernoulli_from_below_with_order_two(supports):
    gaps = []
    for length in (2.0, 4.0, 8.0):
        beam = {"length": length, "section": BOX, "count": 4, "supports": supports}
        slender = euler_bernoulli_frequencies(**beam, **SLENDER)
        gaps.append(1.0 - timoshenko_frequencies(**beam, **STEEL) / slender)
    gaps = np.array(gaps)
    assert np.all(gaps > 0.0)
    orders = np.log2(gaps[:-1] / gaps[1:])
    np.testing.assert_allclose(orders[-1], 2.0, atol=0.05)


def test_slender_limit_is_reached_to_round_off():
    beam = {"length": 1.0e4, "section": BOX, "count": 5}
    np.testing.assert_allclose(
        timoshenko_frequencies(**beam, **STEEL),
        euler_bernoulli_frequencies(**beam, **SLENDER),
        rtol=1e-8,
    )


def test_trial_shapes_give_upper_bounds():
    # Rayleigh: any shape that is clamped at x = 0, here x^p, bounds the first frequency from above.
    length, stiffness = 1.3, SLENDER["young"] * BOX.second_moment_y
    mass = SLENDER["density"] * BOX.area
    first = euler_bernoulli_frequencies(length=length, section=BOX, **SLENDER, count=1)[0]
    for p in (2.0, 2.2, 3.0):
        strain = (p * (p - 1.0)) ** 2 / (2.0 * p - 3.0) * length ** (2.0 * p - 3.0)
        kinetic = length ** (2.0 * p + 1.0) / (2.0 * p + 1.0)
        assert first < np.sqrt(stiffness * strain / (mass * kinetic)) / (2.0 * np.pi)


def test_a_softer_shear_coefficient_lowers_and_a_number_is_taken_as_it_is():
    beam = {"length": 0.4, "section": BOX, **STEEL, "count": 6}
    stiff, soft = (timoshenko_frequencies(**beam, shear=k) for k in (0.9, 0.7))
    assert np.all(soft < stiff)
    by_rule = timoshenko_frequencies(**beam, shear="timoshenko")
    kappa = BOX.shear_coefficient(0.3, rule="timoshenko")
    np.testing.assert_array_equal(by_rule, timoshenko_frequencies(**beam, shear=kappa))


def test_direction_picks_the_second_moment():
    turned = RectangularSection(BOX.height, BOX.width)
    beam = {"length": 0.7, "count": 3}
    for function, solid in (
        (euler_bernoulli_frequencies, SLENDER),
        (timoshenko_frequencies, STEEL),
    ):
        along_y = function(**beam, **solid, section=BOX, direction="y")
        np.testing.assert_allclose(along_y, function(**beam, **solid, section=turned), rtol=1e-13)
        assert np.all(along_y > function(**beam, **solid, section=BOX))


@settings(max_examples=8, deadline=None)
@given(
    size=st.floats(1e-3, 1e3),
    stiffer=st.floats(1e-3, 1e3),
    heavier=st.floats(1e-3, 1e3),
    supports=st.sampled_from(SUPPORTS),
)
def test_frequencies_scale_with_size_stiffness_and_density(size, stiffer, heavier, supports):
    def frequencies(a, b, c):
        return timoshenko_frequencies(
            length=0.5 * a,
            section=TubeSection(0.05 * a, 0.03 * a),
            young=2e11 * b,
            poisson=0.3,
            density=7800.0 * c,
            count=5,
            supports=supports,
        )

    expected = frequencies(1.0, 1.0, 1.0) * np.sqrt(stiffer / heavier) / size
    np.testing.assert_allclose(frequencies(size, stiffer, heavier), expected, rtol=1e-9)


@pytest.mark.parametrize("ends", ["fixed-free", "fixed-fixed", "free-free"])
def test_axial_and_torsional_modes_are_standing_waves(ends):
    # A whole number of half waves between equal ends, an odd number of quarter waves otherwise.
    quarters = np.arange(1, 5) * 2 - (ends == "fixed-free")
    axial = axial_frequencies(length=2.0, **SLENDER, count=4, ends=ends)
    speed = np.sqrt(SLENDER["young"] / SLENDER["density"])
    np.testing.assert_allclose(axial, speed * quarters / 8.0, rtol=1e-14)
    rod = CircularSection(0.1)
    twist = torsional_frequencies(length=2.0, section=rod, **STEEL, count=4, ends=ends)
    np.testing.assert_allclose(twist, axial / np.sqrt(2.6), rtol=1e-14)
    plank = RectangularSection(0.2, 0.05)
    slower = torsional_frequencies(length=2.0, section=plank, **STEEL, count=4, ends=ends)
    ratio = np.sqrt(plank.torsion_constant / plank.polar_moment)
    np.testing.assert_allclose(slower, twist * ratio, rtol=1e-14)


def test_bad_input_is_refused_by_name():
    good = {"length": 1.0, "section": BOX, **STEEL, "count": 1}
    for name, error in (
        ("length", BeamError),
        ("young", MaterialError),
        ("poisson", MaterialError),
        ("density", MaterialError),
        ("shear", BeamError),
        ("count", BeamError),
        ("direction", BeamError),
        ("supports", BeamError),
    ):
        for bad in (float("nan"), -2.0, None):
            with pytest.raises(error, match=name):
                timoshenko_frequencies(**{**good, name: bad})
    with pytest.raises(BeamError, match="shear must be one of cowper"):
        timoshenko_frequencies(**good, shear="best")
    with pytest.raises(MaterialError, match="young"):
        axial_frequencies(length=1.0, young=float("inf"), density=1.0, count=1)
    with pytest.raises(BeamError, match="length"):
        euler_bernoulli_frequencies(length=0.0, section=BOX, **SLENDER, count=1)
