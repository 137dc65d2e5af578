import errno
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.runtime import DIRECTIONS, Modes, load_modes, write_archive

Make = Callable[..., Modes]

ARRAY_FIELDS = (
    *("frequencies", "shapes", "points", "cells", "node_numbers", "node_mass"),
    *("residuals", "participation", "centre", "inertia"),
)
SCALAR_FIELDS = ("cell_type", "rigid_modes", "complete", "total_mass")


def test_file_round_trip_is_bitwise(make_modes: Make, tmp_path: Path) -> None:
    modes = make_modes()
    modes.save(tmp_path / "modes.npz")
    found = load_modes(tmp_path / "modes.npz")
    for name in ARRAY_FIELDS:
        expected = getattr(modes, name)
        assert getattr(found, name).dtype == expected.dtype
        assert getattr(found, name).tobytes() == expected.tobytes()
    for name in SCALAR_FIELDS:
        assert getattr(found, name) == getattr(modes, name)
        assert type(getattr(found, name)) is type(getattr(modes, name))


def test_same_modes_same_bytes(make_modes: Make, tmp_path: Path) -> None:
    make_modes().save(tmp_path / "a.npz")
    load_modes(tmp_path / "a.npz").save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_plain_numpy_shows_the_contract(make_modes: Make, tmp_path: Path) -> None:
    modes = make_modes()
    modes.save(tmp_path / "modes.npz")
    with np.load(tmp_path / "modes.npz") as archive:
        for name in ("frequencies", "shapes", "points", "cells"):
            np.testing.assert_array_equal(archive[name], getattr(modes, name))


def test_failing_disk_keeps_the_old_file(
    make_modes: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "modes.npz"
    make_modes().save(path)
    before = path.read_bytes()
    real, calls = np.lib.format.write_array, []

    def fill_up(*args: Any, **kwargs: Any) -> None:
        calls.append(args)
        if len(calls) == 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        real(*args, **kwargs)

    monkeypatch.setattr(np.lib.format, "write_array", fill_up)
    with pytest.raises(DefoError, match="No space left"):
        make_modes(total_mass=7.0).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_limited_file_size_keeps_the_old_file(make_modes: Make, tmp_path: Path) -> None:
    path = tmp_path / "modes.npz"
    make_modes().save(path)
    before = path.read_bytes()
    script = (
        "import resource, sys\n"
        "from fenics_defo.errors import DefoError\n"
        "from fenics_defo.runtime import load_modes\n"
        "modes = load_modes(sys.argv[1])\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n"
        "    modes.save(sys.argv[1])\n"
        "except DefoError as error:\n"
        "    sys.exit(0 if 'File too large' in str(error) else 3)\n"
        "sys.exit(2)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(path)], check=False)
    assert done.returncode == 0
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_loading_needs_numpy_only(make_modes: Make, tmp_path: Path) -> None:
    path = tmp_path / "modes.npz"
    make_modes().save(path)
    script = (
        "import sys\n"
        "from fenics_defo.runtime import load_modes\n"
        "load_modes(sys.argv[1])\n"
        "heavy = 'dolfinx ufl basix petsc4py slepc4py mpi4py scipy meshio pyvista vtk gmsh h5py'\n"
        "sys.exit(' '.join(set(heavy.split()) & set(sys.modules)) or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(path)], check=False, capture_output=True, text=True
    )
    assert done.stderr.strip() == ""
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frequencies": np.array([1.0, 0.5, 2.0, 3.0])}, "ascend"),
        ({"frequencies": np.array([-1.0, 0.5, 2.0, 3.0])}, "ascend"),
        ({"frequencies": np.array([0.0, 0.5, np.nan, 3.0])}, "frequencies holds values"),
        ({"frequencies": np.ones(3)}, "shapes has the shape"),
        ({"frequencies": np.ones((2, 2))}, "frequencies has the shape"),
        ({"shapes": np.ones((4, 8, 2))}, "shapes has the shape"),
        ({"shapes": np.full((4, 8, 3), np.inf)}, "shapes holds values"),
        ({"shapes": np.ones((4, 8, 3), dtype=complex)}, "shapes has the type complex"),
        ({"points": np.ones((7, 3))}, "shapes has the shape"),
        ({"cells": np.array([[0, 1, 2]])}, "cells has the shape"),
        ({"cells": np.array([[0, 1, 2, 8]])}, "nodes outside 0 to 7"),
        ({"cells": np.array([[0, 1, 2, -1]])}, "nodes outside 0 to 7"),
        ({"cells": np.array([[0.0, 1.0, 2.0, 3.0]])}, "cells has the type float64"),
        ({"cell_type": "tetra10"}, r"cells has the shape \(2, 4\).*\(2, 10\)"),
        ({"cell_type": "wedge"}, "cell_type 'wedge' is not one of"),
        ({"node_numbers": np.arange(7)}, "node_numbers has the shape"),
        ({"node_numbers": np.arange(-1, 7)}, "node_numbers must not be negative"),
        ({"node_mass": -np.ones(8)}, "node_mass must not be negative"),
        ({"residuals": np.ones(3)}, "residuals has the shape"),
        ({"rigid_modes": 5}, "rigid_modes = 5"),
        ({"rigid_modes": -1}, "rigid_modes = -1"),
        ({"participation": np.ones((4, 3))}, "participation has the shape"),
        ({"total_mass": np.nan}, "total_mass"),
        ({"total_mass": 0.0}, "total_mass"),
        ({"centre": np.ones(2)}, "centre has the shape"),
        ({"inertia": np.zeros(6)}, "inertia must be positive"),
    ],
)
def test_inconsistent_records_are_refused(
    make_modes: Make, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        make_modes(**changes)


def test_inconsistent_files_are_refused(make_modes: Make, tmp_path: Path) -> None:
    modes = make_modes()
    arrays = {name: np.asarray(getattr(modes, name)) for name in (*ARRAY_FIELDS, *SCALAR_FIELDS)}
    arrays["cells"] = arrays["cells"] + 5
    write_archive(tmp_path / "a.npz", arrays, kind="modes", version=1, units={})
    with pytest.raises(FileFormatError, match=r"a\.npz: is inconsistent: cells name nodes"):
        load_modes(tmp_path / "a.npz")


def test_arrays_cannot_be_changed(make_modes: Make) -> None:
    modes = make_modes()
    for name in ARRAY_FIELDS:
        with pytest.raises(ValueError, match="read-only"):
            getattr(modes, name)[...] = 0
    with pytest.raises(AttributeError):
        modes.total_mass = 1.0  # type: ignore[misc]


def test_the_caller_keeps_a_writeable_array(make_modes: Make) -> None:
    shapes = np.ones((4, 8, 3))
    make_modes(shapes=shapes)
    assert shapes.flags.writeable


def test_frequencies_omega_and_periods_agree(make_modes: Make) -> None:
    modes = make_modes()
    np.testing.assert_allclose(modes.omega, 2 * np.pi * modes.frequencies)
    assert modes.periods[0] == np.inf
    np.testing.assert_allclose(modes.periods[1:] * modes.frequencies[1:], 1.0)
    assert modes.size == 4


def test_effective_mass_of_rigid_modes_is_everything(make_modes: Make) -> None:
    """Mass-normalised rigid motions r / sqrt(r^T M r) take part with sqrt(r^T M r)."""
    inertia = np.arange(1.0, 7.0)
    modes = make_modes(
        frequencies=np.zeros(6),
        shapes=np.ones((6, 8, 3)),
        residuals=np.zeros(6),
        rigid_modes=6,
        participation=np.diag(np.sqrt(inertia)),
        inertia=inertia,
    )
    np.testing.assert_allclose(modes.effective_mass, np.eye(6))
    np.testing.assert_allclose(modes.cumulative_effective_mass, np.tri(6))
    by_direction = modes.effective_mass_by_direction
    assert tuple(by_direction) == DIRECTIONS
    np.testing.assert_allclose(by_direction["ry"], np.eye(6)[4])


def test_select_keeps_what_belongs_together(make_modes: Make) -> None:
    modes = make_modes()
    chosen = modes.select([3, 0])
    np.testing.assert_array_equal(chosen.frequencies, modes.frequencies[[0, 3]])
    np.testing.assert_array_equal(chosen.shapes, modes.shapes[[0, 3]])
    np.testing.assert_array_equal(chosen.participation, modes.participation[[0, 3]])
    assert chosen.rigid_modes == 1
    assert not chosen.complete
    assert modes.select(slice(0, 2)).complete
    assert modes.select(slice(1, None)).rigid_modes == 0
    np.testing.assert_array_equal(
        modes.select(modes.frequencies > 1.0).frequencies, modes.select([-1, 1, 2]).frequencies
    )


def test_select_refuses_repetition_and_strangers(make_modes: Make) -> None:
    with pytest.raises(ValueError, match="once"):
        make_modes().select([1, -3])
    with pytest.raises(IndexError):
        make_modes().select([4])
