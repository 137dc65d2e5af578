"""Invertible laws: equal to their law above the threshold, continued and restoring below."""

import numpy as np
import pytest
import ufl
from energy_laws import (
    DENSITY,
    FIBRE,
    ISOTROPIC,
    LINEAR,
    LMBDA,
    MOONEY_RIVLIN,
    MU,
    NEO_HOOKEAN,
    POISSON,
    STVK,
    YEOH,
    YOUNG,
    deformations,
    name,
    piola,
    psi,
    rotations,
    tangents,
)
from scipy.optimize import minimize

from fenics_defo import energy
from fenics_defo.energy.principal import StretchEnergy
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.laws import signed_svd

THRESHOLD = 0.2


def composed(stretches, seed=21):
    s = np.atleast_2d(np.asarray(stretches, dtype=float))
    return (rotations(len(s), seed) * s[:, None]) @ rotations(len(s), seed + 1)


def scattered(*stretches, size=0.03, count=8):
    noise = size * np.random.default_rng(22).uniform(-1, 1, (count, 3))
    return composed(np.array(stretches) + noise)


# No stretch comes nearer to the threshold than the widest difference reaches, and s2 + s3 > 0.3.
POINTS = {
    "random": scattered(1.2, 1.0, 0.7, size=0.2),
    "near rest": scattered(1.0, 1.0, 1.0, size=1e-6),
    "stretched": scattered(3.0, 1.5, 0.5),
    "two equal": composed(np.tile([1.1, 1.1, 0.6], (8, 1))),
    "three equal": composed(np.tile([0.9, 0.9, 0.9], (8, 1))),
    "nearly equal": scattered(1.1, 1.1, 0.8, size=1e-9),
    "nearly singular": scattered(1.2, 0.8, 0.0, size=1e-7),
    "flat": composed(np.tile([1.2, 0.8, 0.0], (8, 1))),
    "inverted": scattered(1.3, 1.0, -0.4),
    "equal and inverted": composed(np.tile([1.2, 1.2, -0.5], (8, 1))),
    "below the threshold": scattered(1.1, 0.9, 0.1),
    "crushed twice": scattered(1.1, 0.12, 0.08, size=0.01),
}
HARD = {
    "point": np.zeros((3, 3, 3)),
    "line": composed([[1.3, 0.0, 0.0], [1.3, 1e-9, -3e-10]]),
    "turned inside out": composed(np.tile([1.0, 1.0, -1.0], (4, 1))),
    "far away": 50.0 * np.random.default_rng(23).normal(size=(50, 3, 3)),
    "scattered": np.random.default_rng(24).normal(size=(200, 3, 3)),
}
WHOLE = [kind for kind, F in POINTS.items() if signed_svd(F)[1].min() > THRESHOLD]


def respond(material, F, *, tangent="exact", threshold=THRESHOLD):
    law = energy.Invertible(material, threshold=threshold, tangent=tangent)
    return law.respond(F, law.parameters)


def check_derivative(function, derivative, F, step):
    H = np.random.default_rng(25).uniform(-1, 1, F.shape)
    exact = np.einsum("m...ij,mij->m...", derivative, H)
    scale = np.abs(exact).max() + np.abs(function(F + 0.05 * H)).max()

    def error(h):
        return np.abs((function(F + h * H) - function(F - h * H)) / (2 * h) - exact).max()

    coarse, fine = error(step), error(step / 2)
    if coarse > 1e-7 * scale:
        assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.15)
    assert error(1e-5) < 1e-7 * scale


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
@pytest.mark.parametrize("kind", POINTS)
def test_stress_and_tangent_are_derivatives_above_and_below_the_threshold(material, kind):
    F = POINTS[kind]
    response = respond(material, F)
    check_derivative(lambda G: respond(material, G).energy, response.stress, F, 2e-3)
    check_derivative(lambda G: respond(material, G).stress, response.tangent, F, 2e-3)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
@pytest.mark.parametrize("kind", WHOLE)
def test_above_the_threshold_it_is_the_law(material, kind):
    """Against UFL's own derivatives in F."""
    F = POINTS[kind]
    response = respond(material, F)
    np.testing.assert_allclose(response.energy, psi(material, F), rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(response.stress, piola(material, F), rtol=0, atol=1e-12 * 10)
    expected = tangents(material, F)
    np.testing.assert_allclose(
        response.tangent, expected, rtol=0, atol=1e-9 * np.abs(expected).max()
    )


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
@pytest.mark.parametrize("kind", POINTS)
def test_rotations_before_and_after_turn_the_answer(material, kind):
    F = POINTS[kind]
    Q, W = rotations(len(F), 1), rotations(len(F), 2)
    plain, turned = respond(material, F), respond(material, Q @ F @ W)
    np.testing.assert_allclose(turned.energy, plain.energy, rtol=1e-11, atol=1e-12)
    scale = np.abs(plain.tangent).max()
    np.testing.assert_allclose(turned.stress, Q @ plain.stress @ W, rtol=0, atol=1e-11 * scale)
    expected = np.einsum("mia,mbj,mabcd,mkc,mdl->mijkl", Q, W, plain.tangent, Q, W)
    np.testing.assert_allclose(turned.tangent, expected, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_rest_has_no_stress_and_hookes_stiffness(material):
    law = energy.Invertible(material)
    assert law.linearised() == pytest.approx((YOUNG, POISSON))
    response = law.respond(np.eye(3)[None], law.parameters)
    assert abs(response.energy[0]) < 1e-14
    assert np.abs(response.stress).max() < 1e-13
    np.testing.assert_allclose(response.tangent, tangents(material, np.eye(3)), atol=1e-11)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_energy_and_stress_have_no_jump_at_the_threshold(material):
    gap = 1e-9
    above, below = (composed([[1.3, 0.9, THRESHOLD + side * gap]]) for side in (1, -1))
    upper, lower = respond(material, above), respond(material, below)
    stiffness = np.abs(upper.tangent).max() + np.abs(lower.tangent).max()
    assert abs(upper.energy - lower.energy)[0] < 10 * gap * np.abs(upper.stress).max()
    np.testing.assert_allclose(upper.stress, lower.stress, rtol=0, atol=10 * gap * stiffness)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_below_the_threshold_stress_is_linear_and_pushes_back(material):
    s3 = np.linspace(0.15, -0.85, 6)
    F = np.zeros((6, 3, 3))
    F[:, 0, 0], F[:, 1, 1], F[:, 2, 2] = 1.1, 0.9, s3
    pressed = respond(material, F).stress[:, 2, 2]
    np.testing.assert_allclose(np.diff(pressed, 2), 0.0, atol=1e-11 * np.abs(pressed).max())
    assert (np.diff(pressed) < -0.15 * (LMBDA + 2 * MU)).all()  # as stiff as at rest, or stiffer
    assert pressed.max() < 0.0


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
@pytest.mark.parametrize("kind", [*POINTS, *HARD])
def test_definite_tangent_has_no_negative_eigenvalue(material, kind):
    F = POINTS.get(kind, HARD.get(kind))
    matrices = respond(material, F, tangent="definite").tangent.reshape(-1, 9, 9)
    scale = np.abs(matrices).max(axis=(1, 2))
    np.testing.assert_allclose(matrices, matrices.transpose(0, 2, 1), atol=1e-13 * scale.max())
    assert (np.linalg.eigvalsh(matrices)[:, 0] > -1e-13 * scale).all()


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_definite_tangent_keeps_the_eigenvalues_that_are_not_negative(material):
    F = np.concatenate(list(POINTS.values()))
    exact, definite = (
        respond(material, F, tangent=kind).tangent.reshape(-1, 9, 9)
        for kind in ("exact", "definite")
    )
    values, raised = np.linalg.eigvalsh(exact), np.linalg.eigvalsh(definite)
    scale = np.abs(exact).max(axis=(1, 2))[:, None]
    expected = np.sort(np.maximum(values, 0.0), axis=1)
    assert (np.abs(raised - expected) < 1e-11 * scale).all()
    good = values[:, 0] > 1e-10 * scale[:, 0]
    assert 0 < good.sum() < len(F)
    np.testing.assert_array_equal(definite[good], exact[good])


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
@pytest.mark.parametrize("kind", HARD)
@pytest.mark.parametrize("tangent", ["exact", "definite"])
def test_everything_is_finite_however_crushed_or_inverted(material, kind, tangent):
    response = respond(material, HARD[kind], tangent=tangent, threshold=0.1)
    for values in (response.energy, response.stress, response.tangent):
        assert np.isfinite(values).all()


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_a_point_comes_back_to_rest_from_anywhere(material):
    """Descent of the energy in F ends in a rotation: no other shape is free of stress."""
    law = energy.Invertible(material)

    def target(x):
        response = law.respond(x.reshape(1, 3, 3), law.parameters, tangent=False)
        return response.energy[0], response.stress.ravel()

    for start in np.random.default_rng(26).normal(size=(12, 3, 3)):
        end = minimize(target, start.ravel(), jac=True, method="BFGS", options={"gtol": 1e-9})
        F = end.x.reshape(3, 3)
        np.testing.assert_allclose(F.T @ F, np.eye(3), atol=1e-6)
        assert np.linalg.det(F) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("material", [NEO_HOOKEAN, MOONEY_RIVLIN, YEOH], ids=name)
def test_fields_of_constants_are_taken_point_by_point(material):
    F = np.concatenate([POINTS["random"], POINTS["inverted"], POINTS["crushed twice"]])
    factor = np.linspace(1, 2, len(F))
    law = energy.Invertible(material)
    fields = {key: value * factor for key, value in material.parameters.items()}
    mixed = law.respond(F, fields)
    alike = law.respond(F, law.parameters)
    # Energies of these laws are of first degree in their constants.
    np.testing.assert_allclose(mixed.energy, factor * alike.energy, rtol=1e-11)
    np.testing.assert_allclose(mixed.stress, factor[:, None, None] * alike.stress, rtol=1e-9)
    scaled = factor[:, None, None, None, None] * alike.tangent
    np.testing.assert_allclose(mixed.tangent, scaled, rtol=0, atol=1e-9 * np.abs(scaled).max())


def test_a_point_that_is_no_number_stays_so_and_spoils_nothing_else():
    F = POINTS["random"].copy()
    F[3, 0, 1] = np.nan
    response = respond(NEO_HOOKEAN, F, tangent="definite")
    assert np.isnan(response.energy[3])
    assert np.isnan(response.stress[3]).any()
    assert np.isnan(response.tangent[3]).any()
    assert np.isfinite(np.delete(response.tangent, 3, axis=0)).all()


def test_stretch_energy_agrees_with_the_energy_of_F():
    s = 1 + 0.3 * np.random.default_rng(27).uniform(-1, 1, (10, 3))
    F = s[:, :, None] * np.eye(3)
    for material in ISOTROPIC:
        values, slopes, curvatures = StretchEnergy.of(material)(s, *material.parameters.values())
        np.testing.assert_allclose(values, psi(material, F), rtol=1e-11, atol=1e-14)
        np.testing.assert_allclose(
            slopes, np.einsum("mii->mi", piola(material, F)), rtol=1e-10, atol=1e-12
        )
        np.testing.assert_allclose(
            curvatures, np.einsum("miijj->mij", tangents(material, F)), rtol=1e-10, atol=1e-11
        )


@pytest.mark.parametrize("material", [LINEAR, FIBRE, energy.Corotational, "neo-hookean"])
def test_laws_without_an_energy_of_the_invariants_are_refused(material):
    with pytest.raises(MaterialError, match=r"needs an energy of the principal stretches.*use St"):
        energy.Invertible(material)


@pytest.mark.parametrize("threshold", [0.0, 1.0, -0.1, np.nan, np.inf, "0.1", [0.1, 0.2], True])
def test_a_threshold_out_of_range_is_refused(threshold):
    with pytest.raises(MaterialError, match="threshold must be"):
        energy.Invertible(STVK, threshold=threshold)


@pytest.mark.parametrize("tangent", ["approximate", None, 1])
def test_a_tangent_of_no_kind_is_refused(tangent):
    with pytest.raises(MaterialError, match='tangent must be "definite" or "exact"'):
        energy.Invertible(STVK, tangent=tangent)
    with pytest.raises(MaterialError, match='tangent must be "exact", "definite" or'):
        energy.Corotational(young=1.0, poisson=0.3, density=1.0, tangent=tangent and 2)


def test_laws_at_points_are_told_from_energies_and_from_each_other():
    moduli = {"young": YOUNG, "poisson": POISSON, "density": DENSITY}
    warped = energy.Corotational(**moduli, tangent="approximate")
    laws = [energy.Invertible(NEO_HOOKEAN), energy.Corotational(**moduli), warped]
    for law in laws:
        assert isinstance(law, energy.PointLaw)
        assert not isinstance(law, energy.Material)
        assert law.density == DENSITY
        assert law.linearised() == pytest.approx((YOUNG, POISSON))
    softer = energy.Invertible(energy.NeoHookean(young=1.0, poisson=0.1, density=1.0))
    assert laws[0].formula == softer.formula
    others = [energy.Invertible(STVK), energy.Invertible(NEO_HOOKEAN, threshold=0.2)]
    others.append(energy.Invertible(NEO_HOOKEAN, tangent="exact"))
    assert len({law.formula for law in [*laws, *others]}) == 6
    assert laws[1] == energy.Corotational(**moduli)
    assert hash(laws[1]) == hash(energy.Corotational(**moduli))
    assert laws[1] != warped


def test_springs_are_neither_energies_nor_laws_at_points():
    springs = energy.MassSpring(young=YOUNG, density=DENSITY)
    assert not isinstance(springs, energy.Material | energy.PointLaw)
    assert springs.linearised() == (YOUNG, 0.25)
    field = energy.MassSpring(young=np.array([1.0, 2.0]), density=1.0)
    np.testing.assert_array_equal(field.linearised()[1], [0.25, 0.25])
    with pytest.raises(MaterialError, match="young must be positive"):
        energy.MassSpring(young=np.nan, density=1.0)


def test_a_users_constant_without_a_name_stays_apart():
    """Two energies of one class and different numbers inside are different formulas."""
    first, second = (
        energy.IsotropicEnergy(lambda I1, I2, J, c, k=k: k * (I1 - 3 - 2 * ufl.ln(J)), density=1.0)
        for k in (1.0, 2.0)
    )
    assert energy.formula(first) != energy.formula(second)
    F = deformations(3)
    ratio = respond(second, F).energy / respond(first, F).energy
    np.testing.assert_allclose(ratio, 2.0)
