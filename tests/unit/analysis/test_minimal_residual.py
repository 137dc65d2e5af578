"""GMRES against a dense solve."""

import numpy as np
import pytest

from fenics_defo.analysis.minimal_residual import minimal_residual


def solved(matrix, right_side, **options):
    asked = {"tolerance": 1e-12, "most": 40, **options}
    return minimal_residual(lambda x: matrix @ x, right_side, product=np.vdot, **asked)


def test_it_solves_what_is_almost_the_identity():
    rng = np.random.default_rng(0)
    matrix = np.eye(30) + 0.05 * rng.standard_normal((30, 30))
    right_side = rng.standard_normal(30)
    expected = np.linalg.solve(matrix, right_side)
    assert solved(matrix, right_side) == pytest.approx(expected, abs=1e-10)
    rough = solved(matrix, right_side, most=2)
    errors = [np.linalg.norm(matrix @ x - right_side) for x in (rough, right_side)]
    assert errors[0] < errors[1]


def test_nothing_and_the_identity():
    right_side = np.array([3.0, -4.0])
    assert solved(np.eye(2), right_side) == pytest.approx(right_side, abs=1e-15)
    assert not solved(np.eye(2), np.zeros(2)).any()
