"""The block Lanczos iteration, on dense matrices and one rank."""

from mpi4py import MPI

import numpy as np
import pytest
from scipy import linalg

from fenics_defo.analysis.lanczos import block_lanczos
from fenics_defo.errors import EigenSolveError


def pencil(values, seed=0):
    """K and M with the given eigenvalues, M far from the identity."""
    rng = np.random.default_rng(seed)
    size = len(values)
    root = np.eye(size) + 0.3 * rng.standard_normal((size, size)) / np.sqrt(size)
    turn = np.linalg.qr(rng.standard_normal((size, size)))[0]
    return root.T @ (turn * values) @ turn.T @ root, root.T @ root


def run(stiffness, mass, count, *, width=4, seed=0, **options):
    size, rng = len(mass), np.random.default_rng(seed)
    factor = linalg.cho_factor(stiffness)
    return block_lanczos(
        lambda block: np.asfortranarray(linalg.cho_solve(factor, block)),
        lambda block: np.asfortranarray(mass @ block),
        lambda: np.asfortranarray(rng.standard_normal((size, width))),
        count,
        comm=MPI.COMM_SELF,
        independent=size,
        **options,
    )


@pytest.mark.parametrize("width", [1, 2, 4, 7])
def test_it_finds_the_smallest_values(width):
    values = np.arange(1.0, 121.0) ** 2
    stiffness, mass = pencil(values)
    found = run(stiffness, mass, 9, width=width, guard=2)
    assert found.converged >= 9
    assert 1.0 / found.theta[:9] == pytest.approx(values[:9], rel=1e-9)
    x = found.vectors
    assert x.T @ mass @ x == pytest.approx(np.eye(x.shape[1]), abs=1e-10)
    exact = linalg.eigh(stiffness, mass)[1][:, :9]
    assert np.abs(np.diag(exact.T @ mass @ x[:, :9])) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("count", [1, 5, 11, 12])
def test_all_values_of_a_small_space(count):
    values = np.linspace(1.0, 3.0, 12)
    found = run(*pencil(values), count)
    assert 1.0 / found.theta[:count] == pytest.approx(values[:count], rel=1e-10)


def test_multiple_values_up_to_the_width_of_the_block():
    values = np.concatenate([[1.0] * 4, [2.0] * 3, [5.0] * 2, np.arange(6.0, 60.0)])
    found = run(*pencil(values), 9, guard=2)
    assert 1.0 / found.theta[:9] == pytest.approx(values[:9], rel=1e-9)


def test_an_invariant_subspace_does_not_end_the_search():
    values = np.array([1.0] * 7 + [2.0] * 6)  # two values: the block's space closes at once
    found = run(*pencil(values), 13)
    assert 1.0 / found.theta == pytest.approx(values, rel=1e-9)


def test_restarts_lead_to_the_same_values():
    values = np.arange(1.0, 201.0)
    stiffness, mass = pencil(values)
    short = run(stiffness, mass, 6, basis_limit=24)
    assert 1.0 / short.theta[:6] == pytest.approx(values[:6], rel=1e-9)
    assert short.solves > run(stiffness, mass, 6).solves


def test_too_few_restarts_are_an_error():
    with pytest.raises(EigenSolveError, match=r"of 6 modes converged after 1 restarts"):
        run(*pencil(np.linspace(1.0, 1.1, 200)), 6, basis_limit=14, max_restarts=1)


def test_more_than_the_space_holds_is_an_error():
    with pytest.raises(EigenSolveError, match="only 5 independent motions, and 6 modes"):
        run(*pencil(np.arange(1.0, 6.0)), 6)
