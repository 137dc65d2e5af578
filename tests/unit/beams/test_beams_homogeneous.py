"""Stresses of homogeneous deformations against the derivatives of the energies and known limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.beams import (
    BeamError,
    compressive_limit,
    equibiaxial_tension,
    principal_stresses,
    simple_shear,
    uniaxial_tension,
)
from fenics_defo.errors import MaterialError

HOOKE = {"young": 2.6, "poisson": 0.3}  # mu = 1, lambda = 1.5
RUBBER = {"c10": 0.3, "c01": 0.2, "bulk": 4.0}
LAWS = {
    "linear": HOOKE,
    "corotational": HOOKE,
    "st-venant-kirchhoff": HOOKE,
    "neo-hookean": HOOKE,
    "mooney-rivlin": RUBBER,
}
each_law = pytest.mark.parametrize("law", LAWS)


def energy(law, F):
    """psi(F) by the definitions, the corotational law through the singular values."""
    C, J = F.T @ F, np.linalg.det(F)
    first = np.trace(C)
    second = 0.5 * (first**2 - np.trace(C @ C))
    if law == "mooney-rivlin":
        modified = 0.3 * (J ** (-2 / 3) * first - 3.0) + 0.2 * (J ** (-4 / 3) * second - 3.0)
        return modified + 2.0 * (J - 1.0) ** 2
    if law == "neo-hookean":
        return 0.5 * (first - 3.0) - np.log(J) + 0.75 * np.log(J) ** 2
    if law == "corotational":
        strain = np.diag(np.linalg.svd(F, compute_uv=False) - 1.0)
    else:
        strain = 0.5 * (F + F.T) - np.eye(3) if law == "linear" else 0.5 * (C - np.eye(3))
    return 0.75 * np.trace(strain) ** 2 + np.sum(strain**2)


def derivative(law, F, step=1e-5):
    result = np.empty((3, 3))
    for i, j in np.ndindex(3, 3):
        aside = np.zeros((3, 3))
        aside[i, j] = step
        result[i, j] = (energy(law, F + aside) - energy(law, F - aside)) / (2.0 * step)
    return result


@each_law
def test_principal_stresses_derive_from_the_energy(law):
    stretches = np.array([1.3, 0.8, 1.1])
    found = principal_stresses(law, stretches, **LAWS[law])
    np.testing.assert_allclose(np.diag(found), derivative(law, np.diag(stretches)), atol=1e-9)


@each_law
@pytest.mark.parametrize("amount", [0.6, -1.4])
def test_simple_shear_derives_from_the_energy(law, amount):
    F = np.eye(3)
    F[0, 1] = amount
    found = simple_shear(law, amount=amount, **LAWS[law])
    np.testing.assert_allclose(found, derivative(law, F), atol=1e-9)


@each_law
@given(stretch=st.floats(0.7, 1.4))
def test_free_sides_bear_nothing(law, stretch):
    bar = uniaxial_tension(law, stretch=stretch, **LAWS[law])
    sides = np.array([stretch, bar.free_stretch, bar.free_stretch])
    stress = principal_stresses(law, sides, **LAWS[law])
    assert stress == pytest.approx([bar.stress, 0.0, 0.0], abs=1e-13)
    sheet = equibiaxial_tension(law, stretch=stretch, **LAWS[law])
    sides = np.array([stretch, stretch, sheet.free_stretch])
    stress = principal_stresses(law, sides, **LAWS[law])
    assert stress == pytest.approx([sheet.stress, sheet.stress, 0.0], abs=1e-13)
    assert (bar.stress > 0.0) == (sheet.stress > 0.0) == (stretch > 1.0) or stretch == 1.0


@each_law
def test_small_strains_are_hookes(law):
    """E, E / (1 - nu), mu, and the contractions nu and 2 nu / (1 - nu), at first order."""
    mu, bulk = 1.0, 4.0
    young, poisson = 2.6, 0.3
    if law == "mooney-rivlin":
        young = 9.0 * bulk * mu / (3.0 * bulk + mu)
        poisson = (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu))
    strain = 1e-7
    bar = uniaxial_tension(law, stretch=1.0 + strain, **LAWS[law])
    assert bar.stress / strain == pytest.approx(young, rel=2e-6)
    assert (1.0 - bar.free_stretch) / strain == pytest.approx(poisson, rel=2e-6)
    sheet = equibiaxial_tension(law, stretch=1.0 + strain, **LAWS[law])
    assert sheet.stress / strain == pytest.approx(young / (1.0 - poisson), rel=2e-6)
    contraction = 2.0 * poisson / (1.0 - poisson)
    assert (1.0 - sheet.free_stretch) / strain == pytest.approx(contraction, rel=2e-6)
    shear = simple_shear(law, amount=strain, **LAWS[law])
    assert shear[0, 1] / strain == pytest.approx(mu, rel=1e-6)
    assert shear[1, 0] == pytest.approx(shear[0, 1], rel=1e-6)


@pytest.mark.parametrize("stretch", [0.6, 0.9, 1.7])
def test_stresses_with_textbook_formulas(stretch):
    """E (s - 1); E s (s^2 - 1) / 2; mu (s - t^2 / s); none of them is in the module as such."""
    s = stretch
    linear = uniaxial_tension("linear", stretch=s, **HOOKE)
    assert linear.stress == pytest.approx(2.6 * (s - 1.0))
    cubic = uniaxial_tension("st-venant-kirchhoff", stretch=s, **HOOKE)
    assert cubic.stress == pytest.approx(2.6 * s * (s**2 - 1.0) / 2.0)
    log = uniaxial_tension("neo-hookean", stretch=s, **HOOKE)
    assert log.stress == pytest.approx(s - log.free_stretch**2 / s)
    sheet = equibiaxial_tension("neo-hookean", stretch=s, **HOOKE)
    assert sheet.stress == pytest.approx(s - sheet.free_stretch**2 / s)
    flat = equibiaxial_tension("st-venant-kirchhoff", stretch=s, **HOOKE) if s < 1.5 else None
    assert flat is None or flat.stress == pytest.approx(2.6 / 0.7 * s * (s**2 - 1.0) / 2.0)


@pytest.mark.parametrize("stretch", [0.3, 0.7, 2.0, 5.0])
def test_nearly_incompressible_rubber(stretch):
    """bulk -> infinity: P = 2 (c10 + c01 / s) (s - s^-2), and 2 (c10 + c01 s^2) (s - s^-5)."""
    s = stretch
    errors = []
    for bulk in (1e5, 1e6):
        rubber = {"c10": 0.3, "c01": 0.2, "bulk": bulk}
        bar = uniaxial_tension("mooney-rivlin", stretch=s, **rubber)
        sheet = equibiaxial_tension("mooney-rivlin", stretch=s, **rubber)
        assert bar.free_stretch == pytest.approx(s**-0.5, rel=1e-3)
        errors.append(
            [
                bar.stress / (2.0 * (0.3 + 0.2 / s) * (s - s**-2)) - 1.0,
                sheet.stress / (2.0 * (0.3 + 0.2 * s**2) * (s - s**-5)) - 1.0,
            ]
        )
    assert np.abs(errors[1]).max() < 1e-3
    np.testing.assert_allclose(np.array(errors[0]) / errors[1], 10.0, rtol=0.02)


def test_the_limit_of_compression_is_where_the_stress_turns():
    limit = compressive_limit(young=2.6)
    assert limit.stretch == pytest.approx(3.0**-0.5)
    here = uniaxial_tension("st-venant-kirchhoff", stretch=limit.stretch, **HOOKE)
    assert here.stress == pytest.approx(limit.stress)
    for aside in (0.97, 1.03):
        near = uniaxial_tension("st-venant-kirchhoff", stretch=aside * limit.stretch, **HOOKE)
        assert near.stress > limit.stress
    confined = [
        principal_stresses("st-venant-kirchhoff", np.array([s * limit.stretch, 1.0, 1.0]), **HOOKE)
        for s in (0.97, 1.0, 1.03)
    ]
    assert confined[1][0] == pytest.approx(-3.5 / (3.0 * np.sqrt(3.0)))
    assert confined[1][0] < min(confined[0][0], confined[2][0])


def test_auxetic_neo_hookean_stays_on_the_branch_from_rest():
    foam = {"young": 1.0, "poisson": -0.5}
    previous = 1.0
    for s in np.linspace(1.0, 2.0, 41):
        bar = uniaxial_tension("neo-hookean", stretch=float(s), **foam)
        assert previous - 1e-12 <= bar.free_stretch < previous + 0.02
        previous = bar.free_stretch


def test_homogeneous_refusals():
    with pytest.raises(BeamError, match="law must be one of linear"):
        uniaxial_tension("hooke", stretch=1.1, **HOOKE)
    with pytest.raises(BeamError, match="shrink to nothing"):
        uniaxial_tension("st-venant-kirchhoff", stretch=2.1, **HOOKE)
    with pytest.raises(BeamError, match="shrink to nothing"):
        uniaxial_tension("neo-hookean", stretch=0.2, young=1.0, poisson=-0.9)
    with pytest.raises(BeamError, match="stretch must be a positive"):
        equibiaxial_tension("linear", stretch=float("nan"), **HOOKE)
    with pytest.raises(BeamError, match="three positive"):
        principal_stresses("linear", np.array([1.0, -1.0, 1.0]), **HOOKE)
    with pytest.raises(BeamError, match="amount"):
        simple_shear("linear", amount=np.inf, **HOOKE)
    with pytest.raises(MaterialError, match="has the constants c10, c01, bulk; got poisson, young"):
        simple_shear("mooney-rivlin", amount=0.1, **HOOKE)
    with pytest.raises(MaterialError, match="c10 \\+ c01"):
        simple_shear("mooney-rivlin", amount=0.1, c10=0.1, c01=-0.1, bulk=1.0)
    with pytest.raises(MaterialError, match="young"):
        compressive_limit(young=-1.0)
