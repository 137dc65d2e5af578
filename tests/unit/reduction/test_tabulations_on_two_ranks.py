"""Two ranks make the model of one."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.conftest import MpiRun
from tests.unit.reduction import tabulations_on_ranks

pytestmark = pytest.mark.mpi


def test_two_ranks_make_the_model_of_one(mpirun: MpiRun, tmp_path: Path) -> None:
    one: dict[str, NDArray] = tabulations_on_ranks.everything()  # compiles what both need
    path = tmp_path / "two.npz"
    done = mpirun(
        "-m",
        "tests.unit.reduction.tabulations_on_ranks",
        path,
        cwd=Path(__file__).parents[3],
    )
    assert done.returncode == 0, done.stderr
    with np.load(path) as two:
        assert set(two.files) == set(one)
        for name, value in one.items():
            if name == "messages":
                assert set(two[name]) == set(value) != {"no error"}
                continue
            atol = 1e-10 * np.abs(value).max()
            np.testing.assert_allclose(two[name], value, rtol=0.0, atol=atol, err_msg=name)
