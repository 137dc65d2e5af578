"""The free elastic sphere against published values and a Ritz basis that knows no spheres."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.special import factorial2

from fenics_defo.beams import BeamError, sphere_frequencies
from fenics_defo.errors import MaterialError


def ball_moments(powers):
    """Integrals of x^p y^q z^r over the unit ball for integer powers (..., 3)."""
    total = powers.sum(axis=-1)
    moments = 4.0 * np.pi * np.prod(factorial2(np.maximum(powers - 1, 1), exact=False), axis=-1)
    moments = moments / (factorial2(total + 1, exact=False) * (total + 3))
    return np.where(np.any(powers % 2, axis=-1) | np.any(powers < 0, axis=-1), 0.0, moments)


def ritz_wave_numbers(poisson, *, degree):
    """omega a / c_T of the unit ball from all polynomial displacements up to ``degree``.

    The basis of Visscher et al., J. Acoust. Soc. Am. 90 (1991) 2154: upper bounds.
    """
    powers = np.array(
        [p for p in itertools.product(range(degree + 1), repeat=3) if sum(p) <= degree]
    )
    size, unit = len(powers), np.eye(3, dtype=int)
    pairs = powers[:, None, :] + powers[None, :, :]
    lame = 2.0 * poisson / (1.0 - 2.0 * poisson)
    stiffness = np.zeros((3, size, 3, size))
    for i, j in itertools.product(range(3), repeat=2):
        # Integrals of d_i u d_j v for every pair of monomials u, v.
        factor = powers[:, None, i] * powers[None, :, j]
        slopes = factor * ball_moments(np.where(factor[..., None], pairs - unit[i] - unit[j], 0))
        stiffness[i, :, j, :] += lame * slopes
        stiffness[j, :, i, :] += slopes
        if i == j:
            for k in range(3):
                stiffness[k, :, k, :] += slopes
    mass = np.kron(np.eye(3), ball_moments(pairs))
    squares = eigh(stiffness.reshape(3 * size, 3 * size), mass, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0))


def unit_sphere(poisson, count):
    """With c_T = a = 1."""
    return sphere_frequencies(
        radius=1.0, young=2.0 * (1.0 + poisson), poisson=poisson, density=1.0, count=count
    )


@pytest.mark.parametrize("poisson", [-0.4, 0.25])
def test_every_mode_of_a_polynomial_basis_is_found_with_its_multiplicity(poisson):
    ritz = ritz_wave_numbers(poisson, degree=9)
    np.testing.assert_allclose(ritz[:6], 0.0, atol=1e-4)  # rigid motions
    exact = 2.0 * np.pi * unit_sphere(poisson, 40).repeated()[:100]
    ratio = ritz[6:106] / exact
    assert np.all(ratio > 1.0 - 1e-10)
    assert np.all(ratio < 1.0 + 2e-3)
    assert np.all(ratio[:19] < 1.0 + 1e-7)


def test_lambs_steel_ball():
    # Lamb 1882: k_T a / pi = 0.842 for the slowest spheroidal mode of degree 2, nu = 0.3.
    modes = unit_sphere(0.3, 4)
    chosen = [m == ("spheroidal", 2) for m in zip(modes.families, modes.degrees, strict=True)]
    assert modes.wave_numbers[chosen][0] / np.pi == pytest.approx(0.842, abs=5e-4)


def test_published_roots_for_poisson_a_quarter():
    # Lamb 1882, in Love, Treatise, chapter XII: k_T a / pi torsional, k_L a / pi radial.
    modes = unit_sphere(0.25, 60)

    def overtones(family, degree):
        pairs = zip(modes.families, modes.degrees, strict=True)
        return modes.wave_numbers[[pair == (family, degree) for pair in pairs]] / np.pi

    np.testing.assert_allclose(overtones("torsional", 1)[:2], [1.8346, 2.8950], atol=6e-5)
    np.testing.assert_allclose(overtones("torsional", 2)[:2], [0.7961, 2.2715], atol=6e-5)
    radial = overtones("spheroidal", 0) / np.sqrt(3.0)
    np.testing.assert_allclose(radial[:2], [0.8160, 1.9285], atol=6e-5)
    assert overtones("spheroidal", 2)[0] == pytest.approx(0.840, abs=5e-4)


@given(poisson=st.floats(-0.9, 0.49))
@settings(max_examples=10, deadline=None)
def test_torsional_modes_do_not_feel_poisson_and_radial_ones_obey_lambs_equation(poisson):
    modes = unit_sphere(poisson, 12)
    torsional = [f == "torsional" for f in modes.families]
    assert modes.wave_numbers[torsional][0] == pytest.approx(2.501132620, abs=1e-8)
    radial = modes.degrees == 0
    xi = modes.wave_numbers[radial]
    eta = xi * np.sqrt((1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson))
    np.testing.assert_allclose(
        eta * np.cos(eta), (1.0 - xi**2 / 4.0) * np.sin(eta), atol=1e-10, rtol=1e-10
    )


def test_torsional_modes_of_degree_one_obey_the_tangent_equation():
    modes = unit_sphere(0.3, 70)
    chosen = [m == ("torsional", 1) for m in zip(modes.families, modes.degrees, strict=True)]
    x = modes.wave_numbers[chosen]
    np.testing.assert_allclose((3.0 - x**2) * np.sin(x), 3.0 * x * np.cos(x), atol=1e-10)
    np.testing.assert_array_equal(modes.overtones[chosen], np.arange(x.size))


@pytest.mark.parametrize("poisson", [-0.5, 0.3])
def test_the_number_of_modes_follows_weyls_law(poisson):
    # N = (V / 6 pi^2) (2 / c_T^3 + 1 / c_L^3) omega^3 with a surface term of relative order
    # 1 / xi, which a free surface makes positive: the quotient falls towards one.
    modes = unit_sphere(poisson, 120)
    xi = modes.wave_numbers
    slowness = np.sqrt((1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson))
    volume = 2.0 / (9.0 * np.pi) * (2.0 + slowness**3) * xi**3
    total = np.cumsum(modes.multiplicities)
    excess = xi * (total / volume - 1.0)
    last = excess[-50:]
    assert np.all(last > 0.0)
    assert np.ptp(last) < 0.35 * last.mean()


@settings(max_examples=10, deadline=None)
@given(radius=st.floats(1e-9, 1e7), young=st.floats(1e3, 1e12), density=st.floats(1.0, 2e4))
def test_frequencies_scale(radius, young, density):
    modes = sphere_frequencies(radius=radius, young=young, poisson=0.3, density=density, count=6)
    reference = unit_sphere(0.3, 6)
    scale = np.sqrt(young / 2.6 / density) / radius
    np.testing.assert_allclose(modes.frequencies, reference.frequencies * scale, rtol=1e-12)
    assert modes.families == reference.families


def test_record_is_ascending_and_repeats_by_multiplicity():
    modes = unit_sphere(0.25, 8)
    assert np.all(np.diff(modes.frequencies) > 0.0)
    np.testing.assert_array_equal(modes.multiplicities, 2 * modes.degrees + 1)
    assert modes.repeated().shape == (modes.multiplicities.sum(),)
    np.testing.assert_array_equal(modes.repeated()[:5], modes.frequencies[0])


def test_refusals():
    good = {"radius": 1.0, "young": 1.0, "poisson": 0.3, "density": 1.0, "count": 1}
    for name, error in (
        ("radius", BeamError),
        ("count", BeamError),
        ("young", MaterialError),
        ("poisson", MaterialError),
        ("density", MaterialError),
    ):
        for bad in (float("nan"), -1.0, None):
            with pytest.raises(error, match=name):
                sphere_frequencies(**{**good, name: bad})
