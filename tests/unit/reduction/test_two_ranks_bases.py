"""Bases made by two MPI ranks are those that one makes, from the same modes."""

from pathlib import Path

import numpy as np
import pytest
from bent_bodies import SOFT, STVK, beam, beam_arrays

from fenics_defo.analysis import linear_modes
from fenics_defo.energy import Corotational
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid, build_mesh
from fenics_defo.reduction import (
    basis_from_array,
    join,
    linear_basis,
    modal_derivative_basis,
    modal_derivatives,
    snapshot_basis,
)
from fenics_defo.runtime import load_modes

HERE = Path(__file__).parent


def square():
    """A straight bar of square section, whose bending modes come in pairs."""
    points, cells = beam_arrays("hexahedron", (4, 2, 2))
    angle, radius = np.arctan2(points[:, 0], points[:, 2]), np.hypot(points[:, 0], points[:, 2])
    straight = np.stack([angle, points[:, 1] - 0.25, (radius - 2.175) * (0.5 / 0.35)], axis=1)
    return Solid(build_mesh(straight, cells, kind="hexahedron"), STVK, fixed=["x<1e-9"])


BODIES = {
    "held": (lambda: beam(), 4),
    "free": (lambda: beam(held=False), 10),
    "corotational": (lambda: beam(Corotational(**SOFT)), 3),
    "square": (square, 4),
}


def numbers(solid, modes):
    derivatives = modal_derivatives(solid, modes)
    linear = linear_basis(solid, modes, 2)
    curved = modal_derivative_basis(solid, modes, 6, derivatives=derivatives, amplitude=5.0)
    # Singular values far apart: where two are close, round-off turns their vectors.
    size = np.array([1.0, 0.5, 0.2])[:, None, None]
    snapshots = size * modes.shapes[-3:] + derivatives[:3]
    example = snapshot_basis(solid, snapshots, share=1.0)
    given = basis_from_array(solid, snapshots)
    wave = np.where(solid.held, 0.0, np.sin(3.0 * solid.points))
    both = join(solid, linear, basis_from_array(solid, wave[None]))
    bases = (linear, curved, example, given, both)
    return {
        "derivatives": derivatives,
        "values": curved.singular_values,
        **{f"{basis.kind} shapes": basis.shapes for basis in bases},
        **{f"{basis.kind} mass": basis.mass for basis in bases},
    }


def write_all(folder):
    for name, (make, _) in BODIES.items():
        solid = make()
        found = numbers(solid, load_modes(folder / f"{name}.npz"))
        for array in found.values():
            assert (solid.comm.bcast(array, root=0) == array).all(), "ranks disagree"
        if solid.comm.rank == 0:
            np.savez(folder / f"{name} by two.npz", **found)
    try:
        snapshot_basis(solid, "/nowhere", 3)
    except DefoError as error:
        print(error, flush=True)
    else:
        raise AssertionError("a folder that is missing was read")


@pytest.fixture(scope="module")
def folder(mpirun, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two_ranks_bases")
    for name, (make, count) in BODIES.items():
        linear_modes(make(), count).save(folder / f"{name}.npz")
    code = f"import sys, pathlib; sys.path.insert(0, {str(HERE)!r})\n" + (
        "from test_two_ranks_bases import write_all; write_all(pathlib.Path(sys.argv[1]))"
    )
    done = mpirun("-c", code, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("cannot be read") == 2
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("name", BODIES)
def test_two_ranks_find_what_one_finds(name, folder):
    one = numbers(BODIES[name][0](), load_modes(folder / f"{name}.npz"))
    with np.load(folder / f"{name} by two.npz") as two:
        assert set(two) == set(one)
        for key, array in one.items():
            scale = np.abs(array).max()
            assert two[key] == pytest.approx(array, abs=1e-10 * scale), key
