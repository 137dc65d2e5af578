"""Modes computed by two MPI ranks are those that one computes."""

from pathlib import Path

import numpy as np
import pytest
from modal_bodies import box

from fenics_defo.analysis import linear_modes
from fenics_defo.errors import DefoError
from fenics_defo.fem import Fixed
from fenics_defo.runtime import load_modes, mac

HERE = Path(__file__).parent

CASES = {
    "davidson free": ({}, {"count": 14}),
    "davidson clamped": ({"fixed": ["x==0"]}, {"count": 5}),
    "davidson partly": ({"fixed": [Fixed("x==0", "yz"), Fixed("z==0", "z")]}, {"count": 5}),
    "krylov-schur free": ({}, {"count": 14, "solver": "krylov-schur"}),
    "iterative free": ({}, {"count": 14, "solver": "iterative"}),
    "iterative clamped": ({"fixed": ["x==0"]}, {"count": 5, "solver": "iterative"}),
}


def solid_of(case):
    return box((8, 2, 2), (1.0, 0.2, 0.2), kind="hexahedron", **CASES[case][0])


def write_all(folder):
    for case, (_, options) in CASES.items():
        solid = solid_of(case)
        modes = linear_modes(solid, **options)
        checks = np.concatenate([modes.frequencies, modes.shapes.ravel()])
        same = solid.comm.bcast(checks, root=0)
        assert (checks == same).all(), "ranks disagree"
        if solid.comm.rank == 0:
            modes.save(Path(folder, f"{case}.npz"))
    try:
        linear_modes(solid_of("davidson free"), 0)
    except DefoError as error:
        print(error, flush=True)
    else:
        raise AssertionError("count 0 was accepted")


@pytest.fixture(scope="module")
def folder(mpirun, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two_ranks")
    code = f"import sys; sys.path.insert(0, {str(HERE)!r})\n" + (
        "from test_two_ranks_modes import write_all; write_all(sys.argv[1])"
    )
    done = mpirun("-c", code, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("whole number from 1 to 243") == 2
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("case", CASES)
def test_two_ranks_find_what_one_finds(case, folder):
    one = linear_modes(solid_of(case), **CASES[case][1])
    two = load_modes(folder / f"{case}.npz")
    assert two.rigid_modes == one.rigid_modes
    assert two.complete == one.complete
    assert two.frequencies == pytest.approx(one.frequencies, rel=1e-9)
    assert mac(one, two).diagonal() == pytest.approx(1.0, abs=1e-8)
    # Equal frequencies are aligned and signs chosen: the shapes agree, not only their planes.
    scale = np.abs(one.shapes).max()
    assert two.shapes == pytest.approx(one.shapes, abs=1e-5 * scale)
    assert two.participation == pytest.approx(one.participation, abs=1e-5 * one.participation.max())
    assert two.node_mass == pytest.approx(one.node_mass, rel=1e-12)
    assert two.inertia == pytest.approx(one.inertia, rel=1e-12)
    assert (two.points == one.points).all()
    assert (two.cells == one.cells).all()
