"""MUMPS's factors: solutions, inertia, failures in words, and the user's options."""

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from fenics_defo.fem.compat import PETSc
from fenics_defo.fem.linalg import OPTIONS_PREFIX, Factorization, multiply

SIZE = 12


def symmetric(diagonal: np.ndarray) -> PETSc.Mat:
    """A diagonal in 3x3 blocks, coupled within each block."""
    matrix = PETSc.Mat().createBAIJ((SIZE, SIZE), 3, nnz=1, comm=PETSc.COMM_SELF)
    for row in range(SIZE):
        matrix.setValue(row, row, diagonal[row])
    for row in range(0, SIZE, 3):
        matrix.setValue(row, row + 1, 0.1)
        matrix.setValue(row + 1, row, 0.1)
    matrix.assemble()
    matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return matrix


@pytest.fixture
def option() -> Iterator[None]:
    """MUMPS's ordering, as a user sets it: PORD."""
    options = PETSc.Options()
    options[OPTIONS_PREFIX + "mat_mumps_icntl_7"] = 4
    yield
    options.delValue(OPTIONS_PREFIX + "mat_mumps_icntl_7")


def test_solves_for_a_block_at_once() -> None:
    matrix = symmetric(np.arange(1.0, SIZE + 1.0))
    block = np.asfortranarray(np.random.default_rng(0).standard_normal((SIZE, 5)))
    with closing(Factorization(matrix, definite=True)) as factors:
        np.testing.assert_allclose(multiply(matrix, factors.solve(block)), block, rtol=1e-12)


@pytest.mark.parametrize("negative", [0, 1, 5])
def test_counts_negative_eigenvalues(negative: int) -> None:
    diagonal = np.arange(1.0, SIZE + 1.0)
    diagonal[-negative or SIZE :] *= -1.0
    matrix = symmetric(diagonal)
    with closing(Factorization(matrix, definite=False)) as factors:
        assert factors.negative_pivots == negative


def test_users_options_reach_mumps(option: None) -> None:
    matrix = symmetric(np.ones(SIZE))
    with closing(Factorization(matrix, definite=True)) as factors:
        assert factors._factor.getMumpsIcntl(7) == 4
        assert factors._factor.getMumpsIcntl(14) == 50  # ours, where the user says nothing
