"""The space that the search for modes grows, on dense matrices and one rank."""

from mpi4py import MPI

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

from fenics_defo.analysis.ritz_space import RitzSpace

Array = NDArray[np.float64]
SIZE = 40


@pytest.fixture(scope="module")
def matrices() -> tuple[Array, Array]:
    """K with eigenvalues over five decades, and M far from the identity."""
    rng = np.random.default_rng(0)
    root = np.eye(SIZE) + 0.3 * rng.standard_normal((SIZE, SIZE)) / np.sqrt(SIZE)
    turn = np.linalg.qr(rng.standard_normal((SIZE, SIZE)))[0]
    return root.T @ (turn * np.logspace(0, 5, SIZE)) @ turn.T @ root, root.T @ root


def space_of(matrices: tuple[Array, Array]) -> RitzSpace:
    def multiply(block: Array) -> Array:
        return np.asfortranarray(np.hstack([matrix @ block for matrix in matrices]))

    return RitzSpace(multiply, MPI.COMM_SELF, SIZE, SIZE + 12)


def blocks(kind: str) -> list[Array]:
    rng = np.random.default_rng(1)
    first, second, third = (rng.standard_normal((SIZE, 4)) for _ in range(3))
    if kind == "leaning":  # on the basis, but for a ten-millionth
        second = first @ rng.standard_normal((4, 4)) + 1e-7 * second
    if kind == "alike":  # columns that differ by a ten-thousandth
        second = second[:, :1] + 1e-4 * second
    if kind == "uneven":
        second = second * np.logspace(-12, 12, 4)
    return [first, second, third]


@pytest.mark.parametrize("kind", ["apart", "leaning", "alike", "uneven"])
def test_vectors_are_orthonormal_and_span_all_blocks(
    matrices: tuple[Array, Array], kind: str
) -> None:
    stiffness, mass = matrices
    space, given = space_of(matrices), blocks(kind)
    for block in given:
        space.extend(block)
        assert space.grew
        v = space.combine(np.eye(space.size))
    assert v.shape == (SIZE, 12)
    assert v.T @ mass @ v == pytest.approx(np.eye(12), abs=1e-10)
    for block in given:
        unit = block / np.sqrt(np.einsum("ij,ij->j", block, mass @ block))
        assert v @ (v.T @ mass @ unit) == pytest.approx(unit, abs=1e-11)
    values, inner = space.ritz()
    exact = linalg.eigvalsh(v.T @ stiffness @ v, v.T @ mass @ v)
    assert values == pytest.approx(exact, rel=1e-9)
    x = space.combine(inner[:, :5])
    assert x.T @ stiffness @ x == pytest.approx(np.diag(exact[:5]), abs=1e-9 * exact[4])


def test_what_is_in_the_space_adds_nothing(matrices: tuple[Array, Array]) -> None:
    space, first = space_of(matrices), blocks("apart")[0]
    space.extend(first)
    v = space.combine(np.eye(4))
    for block in (first[:, ::-1], np.zeros((SIZE, 3)), 1e-3 * first[:, :1]):
        space.extend(block)
        assert not space.grew
        np.testing.assert_array_equal(space.combine(np.eye(4)), v)
    space.extend(np.column_stack([first[:, 0], np.arange(1.0, SIZE + 1.0)]))
    assert space.size == 5


def test_the_whole_space_holds_all_pairs(matrices: tuple[Array, Array]) -> None:
    space, rng = space_of(matrices), np.random.default_rng(2)
    while space.size < SIZE:
        space.extend(rng.standard_normal((SIZE, 12)))
        space.combine(np.zeros((space.size, 0)))
    assert space.ritz()[0] == pytest.approx(linalg.eigvalsh(*matrices), rel=1e-9)


def test_a_restart_keeps_the_lowest(matrices: tuple[Array, Array]) -> None:
    space, (first, second, third) = space_of(matrices), blocks("apart")
    for block in (first, second):
        space.extend(block)
        values, inner = space.ritz()
        space.combine(inner)
    x = space.combine(inner[:, :3])
    space.restart(values[:3], inner[:, :3])
    assert space.size == 3
    np.testing.assert_allclose(space.combine(np.eye(3)), x)
    space.extend(third)
    v = space.combine(np.eye(7))
    assert v[:, :3] == pytest.approx(x)
    exact = linalg.eigvalsh(v.T @ matrices[0] @ v, v.T @ matrices[1] @ v)
    assert space.ritz()[0] == pytest.approx(exact, rel=1e-9)
