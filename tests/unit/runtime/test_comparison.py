from collections.abc import Callable

import numpy as np
import pytest

from fenics_defo.runtime import Modes, mac

Make = Callable[..., Modes]
RNG = np.random.default_rng(2)
A, B = RNG.normal(size=(3, 20, 3)), RNG.normal(size=(5, 20, 3))
W = RNG.uniform(0.1, 2.0, size=20)


def test_equal_shapes_give_one_and_the_matrix_is_symmetric() -> None:
    own = mac(A, A, weights=W)
    np.testing.assert_allclose(np.diag(own), 1.0, rtol=1e-14)
    np.testing.assert_allclose(own, own.T, rtol=1e-14)
    assert own.max() <= 1.0


def test_swapping_the_sets_transposes() -> None:
    assert mac(A, B).shape == (3, 5)
    np.testing.assert_allclose(mac(A, B, weights=W), mac(B, A, weights=W).T, rtol=1e-12)


@pytest.mark.parametrize("scale", [-1.0, 1e-200, 3e150])
def test_scale_and_sign_do_not_matter(scale: float) -> None:
    np.testing.assert_allclose(mac(scale * A, B), mac(A, B), rtol=1e-10)


def test_rotating_all_shapes_does_not_matter() -> None:
    rotation, _ = np.linalg.qr(RNG.normal(size=(3, 3)))
    np.testing.assert_allclose(mac(A @ rotation, B @ rotation), mac(A, B), rtol=1e-9)


def test_against_the_definition() -> None:
    u, v = A[1], B[2]
    expected = np.sum(W[:, None] * u * v) ** 2
    expected /= np.sum(W[:, None] * u**2) * np.sum(W[:, None] * v**2)
    assert mac(A, B, weights=W)[1, 2] == pytest.approx(expected, rel=1e-12)


def test_weights_make_orthogonal_what_is_orthogonal_in_them() -> None:
    rows, _ = np.linalg.qr(RNG.normal(size=(60, 4)))
    shapes = rows.T.reshape(4, 20, 3) / np.sqrt(W)[:, None]
    np.testing.assert_allclose(mac(shapes, shapes, weights=W), np.eye(4), atol=1e-14)
    assert mac(shapes, shapes)[0, 1] > 1e-6


def test_records_and_arrays_give_the_same(make_modes: Make) -> None:
    modes = make_modes()
    np.testing.assert_array_equal(mac(modes, modes), mac(modes.shapes, modes.shapes))


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(ValueError, match="a has 20 nodes and b has 19"):
        mac(A, B[:, :19])
    with pytest.raises(ValueError, match="must have the shape"):
        mac(A[0], B)
    with pytest.raises(ValueError, match="b holds a shape that vanishes"):
        mac(A, np.zeros((1, 20, 3)))
    with pytest.raises(ValueError, match="a holds a shape that vanishes or is not finite"):
        mac(np.full((1, 20, 3), np.nan), B)
    for weights in (np.ones(19), -W, np.full(20, np.nan)):
        with pytest.raises(ValueError, match="weights must be 20"):
            mac(A, B, weights=weights)
