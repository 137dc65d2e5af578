"""Textbook responses of each law, their formulas written here from the principal stretches."""

import numpy as np
import pytest
from energy_laws import (
    LINEAR,
    LMBDA,
    MOONEY_RIVLIN,
    MU,
    NEO_HOOKEAN,
    POISSON,
    STVK,
    YOUNG,
    name,
    piola,
)

C10, C01, BULK = MOONEY_RIVLIN.c10, MOONEY_RIVLIN.c01, MOONEY_RIVLIN.bulk
STRETCHES = np.array([0.7, 0.9, 1.0, 1.2, 1.8])


def diagonal(*stretches):
    return np.stack(np.broadcast_arrays(*stretches), axis=-1)[..., None] * np.eye(3)


def principal_stress(material, a):
    """Nominal principal stresses for principal stretches a (b, 3), differentiated by hand."""
    J, I1 = a.prod(axis=1, keepdims=True), (a**2).sum(axis=1, keepdims=True)
    I2 = J**2 * (a**-2.0).sum(axis=1, keepdims=True)
    if material is LINEAR:
        return LMBDA * (a - 1).sum(axis=1, keepdims=True) + 2 * MU * (a - 1)
    if material is STVK:
        return a * (LMBDA / 2 * (I1 - 3) + MU * (a**2 - 1))
    if material is NEO_HOOKEAN:
        return MU * (a - 1 / a) + LMBDA * np.log(J) / a
    first = C10 * J ** (-2 / 3) * (2 * a - 2 / 3 * I1 / a)
    second = C01 * J ** (-4 / 3) * (2 * a * (I1 - a**2) - 4 / 3 * I2 / a)
    return first + second + BULK * (J - 1) * J / a


LAWS = [LINEAR, STVK, NEO_HOOKEAN, MOONEY_RIVLIN]


@pytest.mark.parametrize("material", LAWS, ids=name)
@pytest.mark.parametrize(
    "shape",
    [lambda a: (a, 1.0, 1.0), lambda a: (a, a, 1.0), lambda a: (a, a, a), lambda a: (a, 1.1, 0.8)],
    ids=["uniaxial", "equibiaxial", "dilation", "triaxial"],
)
def test_principal_stresses(material, shape):
    a = np.stack(np.broadcast_arrays(*shape(STRETCHES)), axis=-1)
    P = piola(material, a[..., None] * np.eye(3))
    expected = principal_stress(material, a)[..., None] * np.eye(3)
    np.testing.assert_allclose(P, expected, rtol=1e-12, atol=1e-13)


def test_uniaxial_stress_of_the_linear_law():
    a = STRETCHES
    b = 1 - POISSON * (a - 1)
    expected = diagonal(YOUNG * (a - 1), 0.0, 0.0)
    np.testing.assert_allclose(piola(LINEAR, diagonal(a, b, b)), expected, atol=1e-14)


def test_uniaxial_stress_of_st_venant_kirchhoff():
    a = STRETCHES
    b = np.sqrt(1 - POISSON * (a**2 - 1))  # the lateral Green strain is -poisson times the axial
    expected = diagonal(YOUNG / 2 * a * (a**2 - 1), 0.0, 0.0)
    np.testing.assert_allclose(piola(STVK, diagonal(a, b, b)), expected, atol=1e-14)


def test_st_venant_kirchhoff_has_its_limit_point_at_one_over_root_three():
    def pressing_force(a):
        b = np.sqrt(1 - POISSON * (a**2 - 1))
        return -piola(STVK, diagonal(a, b, b))[:, 0, 0]

    limit = 1 / np.sqrt(3)
    a = limit + np.linspace(-0.2, 0.2, 401)
    force = pressing_force(a)
    assert a[np.argmax(force)] == pytest.approx(limit, abs=1e-3)
    assert force.max() == pytest.approx(YOUNG * limit / 3, rel=1e-12)
    assert np.all(np.diff(force)[:200] > 0)
    assert np.all(np.diff(force)[200:] < 0)


def test_uniaxial_stress_of_neo_hookean_without_lateral_traction():
    b = np.array([0.85, 0.95, 1.1])
    # No lateral stress: mu (b² - 1) + lmbda ln(a b²) = 0, solved for the axial stretch a.
    a = np.exp(-MU / LMBDA * (b**2 - 1)) / b**2
    expected = diagonal(MU * (a - b**2 / a), 0.0, 0.0)
    np.testing.assert_allclose(piola(NEO_HOOKEAN, diagonal(a, b, b)), expected, atol=1e-14)


def test_incompressible_tension_of_mooney_rivlin():
    a = STRETCHES
    P = piola(MOONEY_RIVLIN, diagonal(a, a**-0.5, a**-0.5))
    difference = P[:, 0, 0] * a - P[:, 1, 1] * a**-0.5  # of the Cauchy stresses: J = 1
    np.testing.assert_allclose(difference, 2 * (C10 + C01 / a) * (a**2 - 1 / a), atol=1e-13)
    P = piola(MOONEY_RIVLIN, diagonal(a, a, a**-2.0))
    difference = P[:, 0, 0] * a - P[:, 2, 2] * a**-2.0
    np.testing.assert_allclose(difference, 2 * (C10 + C01 * a**2) * (a**2 - a**-4.0), atol=1e-13)


def shear_stress(material, g):
    """First Piola-Kirchhoff (or, for Mooney-Rivlin, Cauchy) stress of x -> x + g y."""
    F = np.eye(3) + g * np.outer([1, 0, 0], [0, 1, 0])
    return piola(material, F)[0], F


@pytest.mark.parametrize("g", [0.05, 0.5, -1.5])
def test_simple_shear(g):
    P, _ = shear_stress(LINEAR, g)
    np.testing.assert_allclose(P, [[0, MU * g, 0], [MU * g, 0, 0], [0, 0, 0]], atol=1e-14)

    P, _ = shear_stress(NEO_HOOKEAN, g)
    np.testing.assert_allclose(P, [[0, MU * g, 0], [MU * g, 0, 0], [0, 0, 0]], atol=1e-14)

    P, _ = shear_stress(STVK, g)
    pressure = LMBDA * g**2 / 2
    expected = [
        [pressure + MU * g**2, MU * g + g * (pressure + MU * g**2), 0],
        [MU * g, pressure + MU * g**2, 0],
        [0, 0, pressure],
    ]
    np.testing.assert_allclose(P, expected, atol=1e-13)

    P, F = shear_stress(MOONEY_RIVLIN, g)
    sigma = P @ F.T
    assert sigma[0, 1] == pytest.approx(2 * (C10 + C01) * g)
    assert sigma[0, 0] - sigma[1, 1] == pytest.approx(2 * (C10 + C01) * g**2)
    assert sigma[1, 1] - sigma[2, 2] == pytest.approx(-2 * C01 * g**2)
    assert np.trace(sigma) == pytest.approx(0.0, abs=1e-13)  # no change of volume, no pressure
