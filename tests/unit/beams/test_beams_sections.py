"""Cross-sections against quadrature, published tables and limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.beams import BeamError, CircularSection, RectangularSection, TubeSection
from fenics_defo.errors import DefoError, MaterialError

RULES = ("cowper", "timoshenko", "static")


def disc_quadrature(outer, inner=0.0):
    """Points and weights that integrate polynomials over a ring exactly (degree < 16)."""
    x, w = np.polynomial.legendre.leggauss(16)
    r = 0.5 * (outer - inner) * x + 0.5 * (outer + inner)
    angle = 2.0 * np.pi * np.arange(32) / 32
    weights = np.outer(0.5 * (outer - inner) * w * r, np.full(32, 2.0 * np.pi / 32))
    return np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), weights


@pytest.mark.parametrize(
    ("section", "outer", "inner"),
    [(CircularSection(0.3), 0.3, 0.0), (TubeSection(0.3, 0.2), 0.3, 0.2)],
)
def test_round_sections_match_quadrature(section, outer, inner):
    y, z, weights = disc_quadrature(outer, inner)
    assert section.area == pytest.approx(weights.sum(), rel=1e-13)
    assert section.second_moment_y == pytest.approx((z**2 * weights).sum(), rel=1e-13)
    assert section.second_moment_z == pytest.approx((y**2 * weights).sum(), rel=1e-13)
    assert section.polar_moment == pytest.approx(((y**2 + z**2) * weights).sum(), rel=1e-13)
    assert section.torsion_constant == section.polar_moment


def test_width_is_along_y_and_height_along_z():
    flat = RectangularSection(width=3.0, height=1.0)
    x, w = np.polynomial.legendre.leggauss(4)
    y, z = 1.5 * x, 0.5 * x
    assert flat.second_moment_z == pytest.approx(1.5 * (y**2 @ w), rel=1e-13)
    assert flat.second_moment_y == pytest.approx(3.0 * 0.5 * (z**2 @ w), rel=1e-13)
    assert flat.second_moment_y < flat.second_moment_z


@pytest.mark.parametrize(
    # Timoshenko and Goodier, Theory of Elasticity: J = k1 long short^3.
    ("ratio", "constant"),
    [(1.0, 0.1406), (1.2, 0.166), (1.5, 0.196), (2.0, 0.229), (3.0, 0.263), (10.0, 0.312)],
)
def test_torsion_of_a_rectangle_matches_the_published_table(ratio, constant):
    tall = RectangularSection(0.2, 0.2 * ratio)
    assert tall.torsion_constant / (ratio * 0.2**4) == pytest.approx(constant, abs=6e-4)
    assert RectangularSection(0.2 * ratio, 0.2).torsion_constant == tall.torsion_constant


@given(ratio=st.floats(1.0, 50.0))
def test_torsion_of_a_rectangle_is_the_plain_series_and_below_the_polar_moment(ratio):
    n = np.arange(1, 2001, 2)
    series = np.sum(np.tanh(0.5 * n * np.pi * ratio) / n**5.0)
    expected = ratio * (1.0 / 3.0 - 64.0 / np.pi**5 * series / ratio)
    section = RectangularSection(1.0, ratio)
    assert section.torsion_constant == pytest.approx(expected, rel=1e-12)
    assert section.torsion_constant < section.polar_moment


def test_thin_strip_twists_as_a_third_of_its_width_times_thickness_cubed():
    section = RectangularSection(1.0, 1e-6)
    assert section.torsion_constant == pytest.approx(1e-18 / 3.0, rel=1e-6)


def test_static_shear_coefficients_follow_from_the_shear_energy():
    # kappa = Q^2 / (A * integral of tau^2): parabolic stress in the rectangle,
    x, w = np.polynomial.legendre.leggauss(8)
    tau = 1.5 * (1.0 - x**2)
    rectangle = RectangularSection(0.2, 0.7).shear_coefficient(0.3, rule="static")
    assert rectangle == pytest.approx(1.0 / (0.5 * tau**2 @ w), rel=1e-13)
    # St. Venant's stress for nu = 0 in the disc (Love, chapter XV).
    y, z, weights = disc_quadrature(1.0)
    across, aside = 3.0 / 8.0 * (1.0 - z**2 - y**2 / 3.0), -0.25 * y * z
    energy = ((across**2 + aside**2) * weights).sum() / CircularSection(1.0).second_moment_y ** 2
    disc = CircularSection(2.0).shear_coefficient(0.3, rule="static")
    assert disc == pytest.approx(1.0 / (np.pi * energy), rel=1e-13)


@pytest.mark.parametrize("rule", RULES)
@given(poisson=st.floats(0.0, 0.49))
def test_shear_coefficients_have_their_limits(rule, poisson):
    disc = CircularSection(0.1).shear_coefficient(poisson, rule=rule)
    pierced = TubeSection(0.1, 1e-6).shear_coefficient(poisson, rule=rule)
    thin = TubeSection(0.1, 0.1 * (1.0 - 1e-7)).shear_coefficient(poisson, rule=rule)
    thin_expected = {
        "cowper": 2.0 * (1.0 + poisson) / (4.0 + 3.0 * poisson),  # Cowper 1966
        "timoshenko": (1.0 + poisson) / (2.0 + poisson),  # Hutchinson 2001
        "static": 0.5,
    }[rule]
    assert pierced == pytest.approx(disc, rel=1e-8)
    assert thin == pytest.approx(thin_expected, rel=1e-6)
    assert thin < disc < 1.0


@pytest.mark.parametrize(
    "section", [RectangularSection(1, 2), CircularSection(1), TubeSection(2, 1)]
)
def test_rules_agree_with_static_without_poisson_effect(section):
    expected = section.shear_coefficient(0.3, rule="static")
    for rule in RULES:
        assert section.shear_coefficient(0.0, rule=rule) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), "1", None, True])
def test_bad_dimensions_are_refused_by_name(bad):
    with pytest.raises(BeamError, match="height must be a positive finite number"):
        RectangularSection(1.0, bad)
    with pytest.raises(BeamError, match="radius"):
        CircularSection(bad)
    with pytest.raises(BeamError, match="inner_radius"):
        TubeSection(1.0, bad)


def test_other_refusals():
    with pytest.raises(BeamError, match="use CircularSection"):
        TubeSection(1.0, 1.0)
    with pytest.raises(BeamError, match="cowper, timoshenko, static"):
        CircularSection(1.0).shear_coefficient(0.3, rule="guess")
    for poisson in (-1.0, 0.5, float("nan")):
        with pytest.raises(MaterialError, match="poisson"):
            RectangularSection(1.0, 1.0).shear_coefficient(poisson)
    assert issubclass(BeamError, DefoError)
    assert issubclass(BeamError, ValueError)
