"""Two moduli of every law, from its constants and from its second derivative at rest."""

import numpy as np
import pytest
import ufl
from energy_laws import FIBRE, ISOTROPIC, LINEAR, POISSON, YEOH, YOUNG, name
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo import energy
from fenics_defo.energy import linear_moduli, rest_state
from fenics_defo.errors import MaterialError

TWO_MODULI = [energy.LinearElastic, energy.StVenantKirchhoff, energy.NeoHookean]


@pytest.mark.parametrize("material", [*ISOTROPIC, LINEAR], ids=name)
def test_laws_linearise_to_their_moduli(material):
    assert material.linearised() == pytest.approx((YOUNG, POISSON), rel=1e-13)
    assert linear_moduli(material) == pytest.approx((YOUNG, POISSON), rel=1e-12)


@pytest.mark.parametrize("law", TWO_MODULI)
def test_fields_linearise_cell_by_cell(law):
    young, poisson = np.array([1.0, 2.0, 1.0, 5.0]), np.array([0.1, 0.3, 0.1, -0.4])
    material = law(young=young, poisson=poisson, density=1.0)
    np.testing.assert_allclose(linear_moduli(material), [young, poisson], rtol=1e-12)
    assert rest_state(material).tangent.shape == (4, 3, 3, 3, 3)
    assert energy.cell_count(material) == 4


def test_fields_of_mooney_rivlin_and_of_the_user_linearise_alike():
    c10 = np.array([1.0, 2.0, 3.0])
    built_in = energy.MooneyRivlin(c10=c10, c01=-0.1, bulk=100.0, density=1.0)
    own = energy.IsotropicEnergy(
        built_in.invariant_energy, {"c10": c10, "c01": -0.1, "bulk": 100.0}, density=1.0
    )
    np.testing.assert_allclose(own.linearised(), built_in.linearised(), rtol=1e-11)


@settings(deadline=None, max_examples=100)
@given(
    mu=st.floats(1e-3, 1e12),
    ratio=st.floats(-0.6, 1e6),
    field=st.booleans(),
)
def test_lame_constants_survive_the_way_through_the_moduli(mu, ratio, field):
    lmbda = ratio * mu
    given_mu = np.full(3, mu) if field else mu
    material = energy.NeoHookean.from_lame(mu=given_mu, lmbda=lmbda, density=1.0)
    np.testing.assert_allclose(material.parameters["mu"], mu, rtol=1e-14)
    accuracy = 1e-14 * (1.0 + abs(ratio))
    np.testing.assert_allclose(material.parameters["lmbda"], lmbda, rtol=accuracy, atol=1e-14 * mu)


def test_moduli_of_a_nearly_incompressible_law_keep_the_shear_modulus():
    material = energy.MooneyRivlin(c10=1.0, c01=0.5, bulk=1e6, density=1.0)
    young, poisson = linear_moduli(material)
    assert young == pytest.approx(material.linearised()[0], rel=1e-9)
    assert 0.5 - poisson == pytest.approx(0.5 - material.linearised()[1], rel=1e-6)


def test_an_anisotropic_energy_has_a_tangent_but_no_two_moduli():
    A = rest_state(FIBRE).tangent[0]
    assert A[0, 0, 0, 0] - A[1, 1, 1, 1] == pytest.approx(2 * FIBRE.constants["fibre"])
    with pytest.raises(MaterialError, match="not isotropic at rest"):
        FIBRE.linearised()


def test_a_stressed_energy_is_told_so():
    stressed = energy.IsotropicEnergy(
        lambda I1, I2, J, c: c["mu"] * (I1 - 3), {"mu": 1.5}, density=1
    )
    with pytest.raises(MaterialError, match=r"stressed at rest.*3\.0"):
        stressed.linearised()


def test_the_first_bad_cell_is_named():
    c1 = np.array([1.0, 1.0, -2.0, -2.0])
    unstable = energy.IsotropicEnergy(
        YEOH.function, {"c1": c1, "c2": 0.0, "c3": 0.0, "bulk": 1.0}, density=1.0
    )
    with pytest.raises(MaterialError, match=r"not stable at rest.*-4\.0, in cell 2"):
        unstable.linearised()


def test_an_energy_without_derivative_at_rest_is_told_so():
    rough = energy.IsotropicEnergy(lambda I1, I2, J, c: ufl.sqrt(I1 - 3), density=1.0)
    with pytest.raises(MaterialError, match="no finite derivatives at rest"):
        rough.linearised()


def test_an_energy_without_constants_works():
    plain = energy.HyperelasticEnergy(
        lambda F, _: ufl.inner(F.T * F - ufl.Identity(3), F.T * F - ufl.Identity(3)), density=1.0
    )
    assert plain.linearised() == pytest.approx((8.0, 0.0))


def test_an_energy_that_is_no_scalar_is_told_so():
    with pytest.raises(MaterialError, match=r"must return a scalar, got shape \(3, 3\)"):
        energy.HyperelasticEnergy(lambda F, c: F, density=1.0).linearised()
    with pytest.raises(MaterialError, match="must return a UFL scalar, got 'soft'"):
        energy.HyperelasticEnergy(lambda F, c: "soft", density=1.0).linearised()


def test_what_has_no_value_at_a_point_is_named():
    own = energy.HyperelasticEnergy(lambda F, c: ufl.erf(ufl.tr(F)), density=1.0)
    with pytest.raises(MaterialError, match="Erf"):
        own.linearised()
