"""What holds for every strain energy: objectivity, rest, derivatives, symmetry, small strains."""

import numpy as np
import pytest
import ufl
from energy_laws import (
    ALL,
    FIBRE,
    ISOTROPIC,
    LINEAR,
    LMBDA,
    MU,
    NEO_HOOKEAN,
    OBJECTIVE,
    deformations,
    name,
    piola,
    psi,
    rotations,
    tangents,
)

from fenics_defo import energy
from fenics_defo.energy import evaluate


@pytest.mark.parametrize("material", OBJECTIVE, ids=name)
def test_a_rotation_after_the_deformation_stores_nothing(material):
    F, Q = deformations(20), rotations(20)
    np.testing.assert_allclose(psi(material, Q @ F), psi(material, F), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_isotropic_laws_do_not_feel_a_rotation_before_the_deformation(material):
    F, Q = deformations(20), rotations(20)
    np.testing.assert_allclose(psi(material, F @ Q), psi(material, F), rtol=1e-12, atol=1e-13)


def test_the_tests_of_invariance_can_fail():
    F, Q = deformations(20), rotations(20)
    assert np.abs(psi(LINEAR, Q @ F) / psi(LINEAR, F) - 1).max() > 0.1
    assert np.abs(psi(FIBRE, F @ Q) / psi(FIBRE, F) - 1).max() > 0.1


@pytest.mark.parametrize("material", ALL, ids=name)
def test_rest_has_neither_energy_nor_stress(material):
    rest = energy.rest_state(material)
    assert abs(rest.energy[0]) < 1e-14
    assert np.abs(rest.stress).max() < 1e-14
    np.testing.assert_allclose(rest.tangent, tangents(material, np.eye(3)), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("material", ALL, ids=name)
@pytest.mark.parametrize(("function", "derivative"), [(psi, piola), (piola, tangents)])
def test_derivatives_agree_with_central_differences_at_second_order(material, function, derivative):
    F, H = deformations(5, seed=2), np.random.default_rng(3).uniform(-1, 1, (5, 3, 3))
    exact = np.einsum("b...ij,bij->b...", derivative(material, F), H)

    def error(step):
        difference = function(material, F + step * H) - function(material, F - step * H)
        return np.abs(difference / (2 * step) - exact).max()

    scale = np.abs(exact).max()
    coarse, fine = error(2e-2), error(1e-2)
    if coarse > 1e-12 * scale:  # central differences are exact for the linear law
        assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)
    assert error(1e-5) < 1e-8 * scale


@pytest.mark.parametrize("material", ALL, ids=name)
def test_tangent_has_the_major_symmetry_of_a_second_derivative(material):
    A = tangents(material, deformations(20))
    np.testing.assert_allclose(A, A.transpose(0, 3, 4, 1, 2), rtol=0, atol=1e-13 * np.abs(A).max())


@pytest.mark.parametrize("material", OBJECTIVE, ids=name)
def test_stresses_of_objective_laws_are_symmetric_and_consistent(material):
    F = deformations(5)
    gradient = ufl.variable(ufl.Identity(3))
    P, S, sigma = (
        evaluate(measure(material, gradient, parameters=material.parameters), {gradient: F})
        for measure in (energy.first_piola, energy.second_piola, energy.cauchy)
    )
    np.testing.assert_allclose(F @ S, P, rtol=0, atol=1e-13)
    np.testing.assert_allclose(S, S.transpose(0, 2, 1), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        sigma, F @ S @ F.transpose(0, 2, 1) / np.linalg.det(F)[:, None, None], atol=1e-12
    )


@pytest.mark.parametrize("material", [*ISOTROPIC, LINEAR], ids=name)
def test_all_laws_of_equal_moduli_agree_at_small_strain(material):
    H = np.random.default_rng(4).uniform(-1, 1, (5, 3, 3))
    strain = (H + H.transpose(0, 2, 1)) / 2
    hooke = LMBDA * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3) + 2 * MU * strain

    def error(step):
        return np.abs(piola(material, np.eye(3) + step * H) / step - hooke).max()

    if material is LINEAR:
        assert error(1e-3) < 1e-12
    else:  # the next term of the stress is of second order in the strain
        assert error(1e-4) < 1e-2
        assert np.log2(error(2e-4) / error(1e-4)) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_energy_of_the_invariants_is_the_energy_of_F(material):
    F = deformations(20)
    C = np.einsum("bki,bkj->bij", F, F)
    # The second invariant as the sum of the principal 2 x 2 minors, another formula than ours.
    minors = [C[:, i, i] * C[:, j, j] - C[:, i, j] ** 2 for i, j in ((0, 1), (1, 2), (0, 2))]
    symbols = [ufl.variable(ufl.as_ufl(1.0)) for _ in range(3)]
    expression = material.invariant_energy(*symbols, material.parameters)
    invariants = (np.trace(C, axis1=1, axis2=2), sum(minors), np.linalg.det(F))
    by_invariants = evaluate(expression, dict(zip(symbols, invariants, strict=True)))
    np.testing.assert_allclose(by_invariants, psi(material, F), rtol=1e-11, atol=1e-13)


def test_modified_invariants_do_not_feel_a_dilation():
    F = deformations(4)
    gradient = ufl.variable(ufl.Identity(3))
    for before, factor in zip(energy.isochoric_invariants(gradient), (1, 1, 8), strict=True):
        np.testing.assert_allclose(
            evaluate(before, {gradient: 2 * F}), factor * evaluate(before, {gradient: F})
        )


def test_every_record_is_a_material_and_the_isotropic_ones_say_so():
    assert all(isinstance(material, energy.Material) for material in ALL)
    assert [isinstance(m, energy.IsotropicMaterial) for m in ALL] == [m in ISOTROPIC for m in ALL]


@pytest.mark.parametrize("material", [NEO_HOOKEAN, FIBRE], ids=name)
def test_the_array_evaluator_agrees_with_ufls_own(material):
    F = deformations(1, seed=7)[0]
    gradient = ufl.variable(ufl.as_matrix(F.tolist()))
    A = energy.tangent(material, gradient, parameters=material.parameters)
    lowered = ufl.algorithms.apply_derivatives.apply_derivatives(
        ufl.algorithms.apply_algebra_lowering.apply_algebra_lowering(A)
    )
    ours = tangents(material, F)[0]
    for entry in ((0, 0, 0, 0), (0, 1, 2, 1), (2, 0, 1, 1)):
        assert ours[entry] == pytest.approx(lowered[entry](()), rel=1e-12)


def test_evaluator_knows_conditions_functions_and_indices():
    rng = np.random.default_rng(5)
    M, s = rng.uniform(0.1, 0.9, (6, 3, 3)), rng.uniform(0.1, 0.9, 6)
    A, x = ufl.variable(ufl.Identity(3)), ufl.variable(ufl.as_ufl(1.0))
    i, j, k = ufl.indices(3)
    cases = {
        ufl.as_tensor(A[i, k] * A[k, j], (j, i)): (M @ M).transpose(0, 2, 1),
        A[i, i] * x: np.trace(M, axis1=1, axis2=2) * s,
        ufl.cofac(A): np.linalg.inv(M).transpose(0, 2, 1) * np.linalg.det(M)[:, None, None],
        ufl.conditional(ufl.And(ufl.gt(x, 0.3), ufl.Not(ufl.ge(x, 0.6))), A, 2 * A): np.where(
            ((s > 0.3) & (s < 0.6))[:, None, None], M, 2 * M
        ),
        ufl.max_value(x, 0.5) + ufl.min_value(A[0, 1], x): np.maximum(s, 0.5)
        + np.minimum(M[:, 0, 1], s),
        ufl.exp(x) * ufl.sin(x) / ufl.sqrt(x) + ufl.atan2(x, A[1, 2]): np.exp(s)
        * np.sin(s)
        / np.sqrt(s)
        + np.arctan2(s, M[:, 1, 2]),
        abs(ufl.ln(x)) ** x: np.abs(np.log(s)) ** s,
    }
    for expression, expected in cases.items():
        np.testing.assert_allclose(evaluate(expression, {A: M, x: s}), expected, rtol=1e-12)
