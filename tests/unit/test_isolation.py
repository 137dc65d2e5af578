"""The tests run in an environment of their own; see tests/conftest.py."""

import json
import os
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# Compiles a kernel that no other test asks for, and prints what is loaded and where it went.
SUM_OVER_RANKS = """
import json
try:
    import dolfinx_solver
except ModuleNotFoundError:
    pass
from mpi4py import MPI
import dolfinx.fem, dolfinx.jit, dolfinx.mesh, ufl

comm = MPI.COMM_WORLD
mesh = dolfinx.mesh.create_unit_interval(comm, 8)
x = ufl.SpatialCoordinate(mesh)[0]
form = dolfinx.fem.form(3.0 * x**2 * ufl.dx)
total = comm.allreduce(dolfinx.fem.assemble_scalar(form), op=MPI.SUM)
options = dolfinx.jit.get_options()
if comm.rank == 0:
    cache = str(options["cache_dir"])
    print(json.dumps([comm.size, total, options["timeout"], cache, form.module.__file__]))
"""


def runs(pid: int) -> bool:
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False


@pytest.mark.mpi
def test_ranks_share_the_projects_kernels(mpirun, tmp_path: Path) -> None:
    done = mpirun("-c", SUM_OVER_RANKS, cwd=tmp_path, env={"HOME": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    # The last line: MPI's transports may print before it where the machine lacks one of them.
    size, total, timeout, cache, kernel = json.loads(done.stdout.splitlines()[-1])
    assert size == 2
    assert total == pytest.approx(1.0, rel=1e-12)
    assert timeout > 10
    assert Path(cache) == ROOT / ".cache" / "tests" / "fenics"
    assert Path(kernel).parent == Path(cache)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.mpi
def test_ranks_that_hang_are_ended(mpirun, tmp_path: Path) -> None:
    code = (
        "import os, pathlib, sys, time\n"
        "pathlib.Path(sys.argv[1], str(os.getpid())).touch()\n"
        "time.sleep(600)\n"
    )
    with pytest.raises(pytest.fail.Exception, match=r"still ran after 3\.0 s"):
        mpirun("-c", code, tmp_path, timeout=3.0)
    ranks = [int(path.name) for path in tmp_path.iterdir()]
    assert len(ranks) == 2
    deadline = time.monotonic() + 5.0
    while any(runs(pid) for pid in ranks):
        assert time.monotonic() < deadline, "a rank outlived its mpiexec"
        time.sleep(0.05)


@pytest.mark.mpi
def test_a_failing_rank_is_seen(mpirun) -> None:
    done = mpirun("-c", "raise SystemExit(3)")
    assert done.returncode == 3


def test_one_thread_per_process() -> None:
    assert os.environ["OMP_NUM_THREADS"]
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"]
