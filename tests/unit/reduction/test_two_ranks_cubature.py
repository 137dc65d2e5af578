"""A cubature trained by two MPI ranks is the one that a single rank trains."""

from pathlib import Path

import numpy as np
import pytest

from fenics_defo.reduction.cubature.training import train_cubature
from tests.unit.reduction.cubature_bodies import TWO, body, shapes_of

ROOT = Path(__file__).parents[3]


def trained():
    solid = body(TWO)
    return train_cubature(solid, shapes_of(solid, 5), tolerance=0.05, seed=4)


def write(path):
    found = trained()
    np.savez(path, weights=found.force.weights, gradients=found.force.gradients)


@pytest.mark.mpi
def test_two_ranks_choose_the_same_points_and_weights(mpirun, tmp_path):
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n" + (
        "from mpi4py import MPI\n"
        "from tests.unit.reduction.test_two_ranks_cubature import write\n"
        f"write({str(tmp_path)!r} + f'/{{MPI.COMM_WORLD.rank}}.npz')"
    )
    mpirun("-c", code)
    one = trained().force
    for rank in (0, 1):
        two = np.load(tmp_path / f"{rank}.npz")
        assert two["weights"].shape == one.weights.shape
        np.testing.assert_allclose(two["gradients"], one.gradients, rtol=0, atol=1e-10)
        np.testing.assert_allclose(two["weights"], one.weights, rtol=1e-6)
