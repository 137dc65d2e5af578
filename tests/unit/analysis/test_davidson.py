"""The block Davidson iteration, on dense matrices and one rank."""

from mpi4py import MPI

import numpy as np
import pytest
from scipy import linalg

from fenics_defo.analysis.davidson import RoughPreconditionerError, SearchedProblem, block_davidson
from fenics_defo.errors import EigenSolveError


def pencil(values, seed=0):
    """K and M with the given eigenvalues, M far from the identity."""
    rng = np.random.default_rng(seed)
    size = len(values)
    root = np.eye(size) + 0.3 * rng.standard_normal((size, size)) / np.sqrt(size)
    turn = np.linalg.qr(rng.standard_normal((size, size)))[0]
    return root.T @ (turn * values) @ turn.T @ root, root.T @ root


def run(stiffness, mass, count, *, width=4, seed=0, inverse=None, **options):
    size, rng = len(mass), np.random.default_rng(seed)
    inverse = linalg.inv(stiffness) if inverse is None else inverse
    both = np.vstack([stiffness, mass])
    problem = SearchedProblem(
        precondition=lambda block: np.asfortranarray(inverse @ block),
        multiply=lambda block: np.hstack(np.vsplit(both @ block, 2)),
        residuals=lambda block, values: np.asfortranarray(
            stiffness @ block - mass @ block * values
        ),
        mass=lambda block: mass @ block,
        random=lambda: rng.standard_normal((size, width)),
        comm=MPI.COMM_SELF,
        independent=size,
    )
    return block_davidson(problem, count, **options)


def values_of(found, stiffness, mass):
    """Rayleigh quotients."""
    x = found.vectors
    return np.einsum("ij,ij->j", x, stiffness @ x) / np.einsum("ij,ij->j", x, mass @ x)


@pytest.mark.parametrize("width", [1, 2, 4, 7])
def test_it_finds_the_smallest_values(width):
    values = np.arange(1.0, 121.0) ** 2
    stiffness, mass = pencil(values)
    found = run(stiffness, mass, 9, width=width, guard=2)
    assert found.converged >= 9
    assert values_of(found, stiffness, mass)[:9] == pytest.approx(values[:9], rel=1e-9)
    x = found.vectors
    assert x[:, :9].T @ mass @ x[:, :9] == pytest.approx(np.eye(9), abs=1e-9)
    exact = linalg.eigh(stiffness, mass)[1][:, :9]
    assert np.abs(np.diag(exact.T @ mass @ x[:, :9])) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("count", [1, 5, 11, 12])
def test_all_values_of_a_small_space(count):
    values = np.linspace(1.0, 3.0, 12)
    matrices = pencil(values)
    found = run(*matrices, count)
    assert values_of(found, *matrices)[:count] == pytest.approx(values[:count], rel=1e-10)


def test_multiple_values_up_to_the_width_of_the_block():
    values = np.concatenate([[1.0] * 4, [2.0] * 3, [5.0] * 2, np.arange(6.0, 60.0)])
    matrices = pencil(values)
    found = run(*matrices, 9, guard=2)
    assert values_of(found, *matrices)[:9] == pytest.approx(values[:9], rel=1e-9)


def test_an_invariant_subspace_does_not_end_the_search():
    values = np.array([1.0] * 7 + [2.0] * 6)  # two values: the block's space closes at once
    matrices = pencil(values)
    found = run(*matrices, 13)
    assert values_of(found, *matrices) == pytest.approx(values, rel=1e-9)


def test_restarts_lead_to_the_same_values():
    values = np.arange(1.0, 201.0)
    stiffness, mass = pencil(values)
    short = run(stiffness, mass, 6, basis_limit=24)
    assert values_of(short, stiffness, mass)[:6] == pytest.approx(values[:6], rel=1e-9)
    assert short.solves > run(stiffness, mass, 6).solves


def test_too_few_restarts_are_an_error():
    with pytest.raises(EigenSolveError, match=r"of 6 modes converged after 1 restarts"):
        run(*pencil(np.linspace(1.0, 1.1, 200)), 6, basis_limit=14, max_restarts=1)


def test_more_than_the_space_holds_is_an_error():
    with pytest.raises(EigenSolveError, match="only 5 independent motions, and 6 modes"):
        run(*pencil(np.arange(1.0, 6.0)), 6)


@pytest.mark.parametrize("error", [1e-3, 0.1, 0.5])
def test_a_rough_preconditioner_leads_to_the_same_vectors(error):
    values = np.arange(1.0, 121.0) ** 2
    stiffness, mass = pencil(values)
    root = linalg.sqrtm(linalg.inv(stiffness)).real
    noise = np.random.default_rng(3).standard_normal(root.shape)
    noise *= error / np.linalg.norm(noise, 2)
    found = run(stiffness, mass, 9, guard=2, inverse=root @ (np.eye(120) + noise) @ root)
    assert values_of(found, stiffness, mass)[:9] == pytest.approx(values[:9], rel=1e-10)
    exact, x = linalg.eigh(stiffness, mass)[1][:, :9], found.vectors[:, :9]
    cosines = np.diag(exact.T @ mass @ x) / np.sqrt(np.diag(x.T @ mass @ x))
    assert np.abs(cosines) == pytest.approx(1.0, abs=1e-9)


def test_what_resembles_no_inverse_is_refused():
    stiffness, mass = pencil(np.arange(1.0, 60.0))
    inverse = linalg.inv(stiffness)
    run(stiffness, mass, 3, inverse=1.05 * inverse, roughest=0.1)
    for wrong in (1.2 * inverse, -inverse, np.nan * inverse, mass):
        with pytest.raises(RoughPreconditionerError, match="errs by"):
            run(stiffness, mass, 3, inverse=wrong, roughest=0.1)
