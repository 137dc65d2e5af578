"""Corotational elasticity at points: derivatives, invariance, rest, inversion, the tangents."""

import numpy as np
import pytest
from law_points import EVERY, HARD, REGULAR, check_derivative, eigenvalues, hooke, rotations

from fenics_defo.runtime.laws import PointResponse, corotational, polar_rotation, signed_svd

MU, LMBDA = 1.3, 2.1
KINDS = ["exact", "definite", "approximate"]


def respond(F, tangent=None):
    return corotational(F, MU, LMBDA, tangent=tangent)


@pytest.mark.parametrize("kind", EVERY)
def test_energy_is_that_of_the_signed_stretches(kind):
    """Another formula: ψ = μ Σ (s_i − 1)² + λ/2 (Σ s_i − 3)²."""
    _, s, _ = signed_svd(EVERY[kind])
    expected = MU * ((s - 1) ** 2).sum(axis=1) + LMBDA / 2 * (s.sum(axis=1) - 3) ** 2
    np.testing.assert_allclose(respond(EVERY[kind]).energy, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("kind", REGULAR)
def test_stress_is_the_derivative_of_the_energy(kind):
    F = REGULAR[kind]
    check_derivative(lambda G: respond(G).energy, respond(F).stress, F)


@pytest.mark.parametrize("kind", REGULAR)
def test_exact_tangent_is_the_derivative_of_the_stress(kind):
    F = REGULAR[kind]
    check_derivative(lambda G: respond(G).stress, respond(F, "exact").tangent, F)


def test_the_other_tangents_are_not_the_derivative():
    F = REGULAR["random"]
    for tangent in ("approximate", "definite"):
        with pytest.raises(AssertionError):
            check_derivative(lambda G: respond(G).stress, respond(F, tangent).tangent, F)


@pytest.mark.parametrize("kind", REGULAR)
def test_rotations_before_and_after_turn_the_answer(kind):
    F = REGULAR[kind]
    Q, W = rotations(len(F), 1), rotations(len(F), 2)
    for tangent in KINDS:
        plain, turned = respond(F, tangent), respond(Q @ F @ W, tangent)
        np.testing.assert_allclose(turned.energy, plain.energy, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(turned.stress, Q @ plain.stress @ W, rtol=0, atol=1e-12)
        expected = np.einsum("mia,mbj,mabcd,mkc,mdl->mijkl", Q, W, plain.tangent, Q, W)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(turned.tangent, expected, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("tangent", KINDS)
def test_rest_and_every_rotation_of_it_is_free_of_stress_and_as_stiff_as_hooke(tangent):
    R = np.concatenate([np.eye(3)[None], rotations(20, 3)])
    response = respond(R, tangent)
    assert np.abs(response.energy).max() < 1e-28
    assert np.abs(response.stress).max() < 1e-14
    turned = np.einsum("mai,mabcd,mck->mibkd", R, response.tangent, R)
    np.testing.assert_allclose(turned, np.tile(hooke(MU, LMBDA), (21, 1, 1, 1, 1)), atol=1e-13)


@pytest.mark.parametrize("kind", EVERY)
def test_approximate_tangent_is_hookes_tensor_turned(kind):
    F = EVERY[kind]
    R, tangent = polar_rotation(F), respond(F, "approximate").tangent
    expected = np.einsum("mia,abcd,mkc->mibkd", R, hooke(MU, LMBDA), R)
    np.testing.assert_allclose(tangent, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", EVERY)
def test_definite_tangent_has_no_negative_eigenvalue(kind):
    assert eigenvalues(respond(EVERY[kind], "definite").tangent).min() > -1e-13


def test_definite_tangent_is_the_exact_one_where_that_is_definite_and_differs_elsewhere():
    F = np.concatenate(list(REGULAR.values()))
    exact, definite = respond(F, "exact").tangent, respond(F, "definite").tangent
    smallest = eigenvalues(exact).min(axis=1)
    good, bad = smallest > 1e-12, smallest < -1e-12
    assert good.sum() > 10
    assert bad.sum() > 10
    np.testing.assert_allclose(definite[good], exact[good], rtol=0, atol=1e-14)
    assert (np.abs(definite - exact)[bad].max(axis=(1, 2, 3, 4)) > 1e-12).all()


def test_definite_tangent_keeps_the_eigenvalues_that_are_not_negative():
    F = REGULAR["inverted"]
    exact, definite = (respond(F, kind).tangent.reshape(-1, 9, 9) for kind in KINDS[:2])
    expected = np.sort(np.maximum(np.linalg.eigvalsh(exact), 0.0), axis=1)
    np.testing.assert_allclose(np.linalg.eigvalsh(definite), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", HARD)
def test_everything_is_finite_where_the_rotation_jumps(kind):
    for tangent in KINDS:
        response = respond(HARD[kind], tangent)
        for values in (response.energy, response.stress, response.tangent):
            assert np.isfinite(values).all()


def test_an_inverted_point_is_pushed_back():
    F = REGULAR["inverted"]
    U, s, V = signed_svd(F)
    principal = np.einsum("mip,mij,mjp->mp", U, respond(F).stress, V)
    assert (s[:, 2] < 0).all()
    assert (principal[:, 2] < -2 * MU).all()


def test_fields_of_constants_are_taken_point_by_point():
    F = REGULAR["random"]
    mu, lmbda = np.linspace(1, 2, len(F)), np.linspace(3, 1, len(F))
    whole = corotational(F, mu, lmbda)
    for i in range(len(F)):
        one = corotational(F[i : i + 1], float(mu[i]), float(lmbda[i]))
        np.testing.assert_allclose(whole.energy[i], one.energy[0], rtol=1e-13)
        np.testing.assert_allclose(whole.stress[i], one.stress[0], rtol=0, atol=1e-13)
        np.testing.assert_allclose(whole.tangent[i], one.tangent[0], rtol=0, atol=1e-12)


def test_the_answer_goes_into_given_arrays_and_the_tangent_only_if_asked_for():
    F = REGULAR["random"]
    out = PointResponse.empty(len(F), tangent=True)
    out.tangent[:] = 7.0
    assert corotational(F, MU, LMBDA, tangent=None, out=out) is out
    np.testing.assert_array_equal(out.stress, respond(F).stress)
    np.testing.assert_array_equal(out.tangent, 7.0)
    corotational(F, MU, LMBDA, out=out)
    np.testing.assert_array_equal(out.tangent, respond(F, "exact").tangent)
    assert respond(F).tangent is None


def test_what_is_no_number_stays_so_and_spoils_nothing_else():
    F = REGULAR["random"].copy()
    F[2, 1, 1] = np.nan
    for tangent in KINDS:
        response, others = respond(F, tangent), np.arange(len(F)) != 2
        assert np.isnan(response.energy[2])
        assert np.isnan(response.stress[2]).any()
        assert np.isnan(response.tangent[2]).any()
        assert np.isfinite(response.tangent[others]).all()
