"""Two ranks give the numbers of one, and agree about errors."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.conftest import MpiRun
from tests.unit.fem import bodies_on_ranks

pytestmark = pytest.mark.mpi

Numbers = dict[str, NDArray]
EXACT = ("points", "cells", "held", "back", "sizes")


@pytest.fixture(scope="module")
def one() -> Numbers:
    return bodies_on_ranks.everything()


@pytest.fixture(scope="module")
def two(mpirun: MpiRun, tmp_path_factory: pytest.TempPathFactory, one: Numbers) -> Numbers:
    """After ``one``, which has compiled what both need."""
    path = tmp_path_factory.mktemp("ranks") / "numbers.npz"
    done = mpirun("-m", "tests.unit.fem.bodies_on_ranks", path, cwd=Path(__file__).parents[3])
    assert done.returncode == 0, done.stderr
    with np.load(path) as kept:
        return dict(kept)


def test_two_ranks_give_the_numbers_of_one(one: Numbers, two: Numbers) -> None:
    assert one.keys() == two.keys()
    for name, value in one.items():
        if name.endswith("/messages"):
            continue
        other = two[name]
        if name.endswith(EXACT):
            np.testing.assert_array_equal(other, value, err_msg=name)
        else:
            # Iterations on other ranks' blocks end elsewhere within their tolerance of 1e-13.
            tolerance = 1e-9 if "/solution-" in name else 1e-12
            scale = tolerance * np.abs(value).max()
            np.testing.assert_allclose(other, value, rtol=0.0, atol=scale, err_msg=name)


def test_both_ranks_hear_of_each_mistake(one: Numbers, two: Numbers) -> None:
    names = [name for name in one if name.endswith("/messages")]
    assert len(names) > 10
    for name in names:
        (alone,), (first, second) = one[name], two[name]
        assert alone != "no error"
        if name.startswith("rank 0 breaks"):
            assert first == alone == "KeyError: 'missing'"
            assert second == "DefoError: rank 0 failed with KeyError('missing')"
        else:
            assert first == second == alone
            assert alone.split(":")[0] in (
                "DefoError",
                "MeshError",
                "SelectionError",
                "MaterialError",
            )
