"""The signed singular value decomposition and the polar rotation of batches."""

import numpy as np
import pytest
from law_points import EPSILON, EVERY, REGULAR, composed, sizes

from fenics_defo.runtime.laws import polar_rotation, signed_svd
from fenics_defo.runtime.laws.batches import BATCH


def assert_proper(R):
    np.testing.assert_allclose(
        R.transpose(0, 2, 1) @ R, np.tile(np.eye(3), (len(R), 1, 1)), rtol=0, atol=2e-14
    )
    np.testing.assert_allclose(np.linalg.det(R), 1.0, rtol=1e-13)


@pytest.mark.parametrize("kind", EVERY)
def test_svd_gives_back_the_matrix_by_proper_rotations(kind):
    F = EVERY[kind]
    U, s, V = signed_svd(F)
    assert_proper(U)
    assert_proper(V)
    error = np.abs((U * s[:, None]) @ V.transpose(0, 2, 1) - F).max(axis=(1, 2))
    assert (error <= 20 * EPSILON * sizes(F)).all()


@pytest.mark.parametrize("kind", EVERY)
def test_only_the_smallest_stretch_is_negative_and_only_where_the_point_is_inverted(kind):
    F = EVERY[kind]
    _, s, _ = signed_svd(F)
    slack = 20 * EPSILON * sizes(F)
    assert (s[:, 0] >= s[:, 1] - slack).all()
    assert (s[:, 1] >= np.abs(s[:, 2]) - slack).all()
    reference = np.linalg.svd(F, compute_uv=False)
    assert (np.abs(np.abs(s) - reference).max(axis=1) <= slack).all()
    clear = reference[:, 2] > 1e-10 * reference[:, 0]
    np.testing.assert_array_equal(np.sign(s[clear, 2]), np.sign(np.linalg.det(F[clear])))


@pytest.mark.parametrize("kind", EVERY)
def test_polar_rotation_is_a_proper_rotation_that_makes_the_trace_largest(kind):
    F = EVERY[kind]
    R = polar_rotation(F)
    assert_proper(R)
    U, s, Vt = np.linalg.svd(F)
    s[:, 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    trace = np.einsum("mij,mij->m", R, F)
    assert (np.abs(trace - s.sum(axis=1)) <= 40 * EPSILON * sizes(F)).all()


@pytest.mark.parametrize("kind", REGULAR)
def test_polar_rotation_leaves_a_symmetric_stretch(kind):
    S = polar_rotation(REGULAR[kind]).transpose(0, 2, 1) @ REGULAR[kind]
    np.testing.assert_allclose(S, S.transpose(0, 2, 1), rtol=0, atol=2e-14)


@pytest.mark.parametrize("exponent", [-3, -6, -9])
def test_polar_rotation_is_as_accurate_as_the_gap_of_the_stretches_allows(exponent):
    """Its condition number is s1/(s2 + s3); from both sides of the closed form's limit."""
    gap = 10.0**exponent
    F = composed([[1.0, gap, gap / 3], [1.0, 0.5, gap - 0.5], [1.0, gap, 0.0], [1.0, 1.0, gap - 1]])
    U, _, Vt = np.linalg.svd(F)
    U[:, :, 2] *= (np.linalg.det(U) * np.linalg.det(Vt))[:, None]
    np.testing.assert_allclose(polar_rotation(F), U @ Vt, rtol=0, atol=50 * EPSILON / gap)


@pytest.mark.parametrize("count", [0, 1, BATCH, BATCH + 1])
def test_a_point_does_not_feel_the_others(count):
    F = np.random.default_rng(0).normal(size=(count, 3, 3))
    some = slice(max(count - 3, 0), count)
    for whole, part in zip(signed_svd(F), signed_svd(F[some]), strict=True):
        np.testing.assert_allclose(whole[some], part, rtol=0, atol=1e-13)
    np.testing.assert_allclose(polar_rotation(F)[some], polar_rotation(F[some]), rtol=0, atol=1e-12)


def test_what_is_no_number_stays_so_and_spoils_nothing_else():
    F = np.tile(np.diag([1.2, 1.0, 0.8]), (4, 1, 1))
    F[1, 0, 2], F[2, 1, 1] = np.nan, np.inf
    R = polar_rotation(F)
    U, s, V = signed_svd(F)
    assert np.isnan(R[1:3]).any(axis=(1, 2)).all()
    assert np.isnan(s[1:3]).any(axis=1).all()
    for found in (R, (U * s[:, None]) @ V.transpose(0, 2, 1)):
        assert np.isfinite(found[[0, 3]]).all()
