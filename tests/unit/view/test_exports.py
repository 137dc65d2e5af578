import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.errors import DefoError
from fenics_defo.runtime import Modes
from fenics_defo.view import check_vtk_path, vtk_xml, write_modes_vtk
from fenics_defo.view.captions import field_names
from fenics_defo.view.offscreen import pyvista

Array = NDArray[np.float64]
Box = Callable[..., Modes]

CELL_TYPES = ("tetra", "tetra10", "hexahedron", "hexahedron27")
VTK_NUMBERS = {"tetra": 10, "tetra10": 24, "hexahedron": 12, "hexahedron27": 29}


def noise(seed: int) -> Callable[[Array], Array]:
    return lambda points: np.random.default_rng(seed).normal(size=points.shape)


@pytest.fixture(params=CELL_TYPES)
def modes(request: pytest.FixtureRequest, box_modes: Box) -> Modes:
    return box_modes(
        request.param,
        [noise(1), noise(2), noise(3)],
        frequencies=[0.0, 440.2, 440.2],
        rigid_modes=1,
    )


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_meshio_and_pyvista_read_what_was_written(
    modes: Modes, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"modes{suffix}"
    write_modes_vtk(modes, path)
    by_meshio, by_pyvista = meshio.read(path), pyvista.read(path)
    for points in (by_meshio.points, np.asarray(by_pyvista.points)):
        np.testing.assert_array_equal(points, modes.points)
    assert by_meshio.cells_dict.keys() == {modes.cell_type}
    np.testing.assert_array_equal(by_meshio.cells_dict[modes.cell_type], modes.cells)
    assert by_pyvista.cells_dict.keys() == {VTK_NUMBERS[modes.cell_type]}
    np.testing.assert_array_equal(next(iter(by_pyvista.cells_dict.values())), modes.cells)
    for found in (by_meshio.point_data, by_pyvista.point_data):
        assert list(found) == [*field_names(modes), "node_number"]
        for name, shape in zip(field_names(modes), modes.shapes, strict=True):
            np.testing.assert_array_equal(found[name], shape)
        np.testing.assert_array_equal(found["node_number"], modes.node_numbers)
    np.testing.assert_array_equal(by_pyvista.field_data["frequencies_hz"], modes.frequencies)


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_vtk_sees_the_volume_of_the_box(modes: Modes, tmp_path: Path, suffix: str) -> None:
    """Which wrong orders of the nodes would not give."""
    path = tmp_path / f"modes{suffix}"
    write_modes_vtk(modes, path)
    sizes = pyvista.read(path).compute_cell_sizes(length=False, area=False)
    np.testing.assert_allclose(sizes.cell_data["Volume"].sum(), 4.0 * 1.0 * 0.5, rtol=1e-6)


@pytest.mark.parametrize("block", [24, 1 << 10, 4800])
def test_blocks_of_any_size_are_read(
    modes: Modes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block: int
) -> None:
    """Among them blocks that end exactly with the array."""
    monkeypatch.setattr(vtk_xml, "_BLOCK", block)
    write_modes_vtk(modes, tmp_path / "modes.vtu")
    found = pyvista.read(tmp_path / "modes.vtu")
    np.testing.assert_array_equal(np.asarray(found.points), modes.points)
    np.testing.assert_array_equal(found.point_data["mode_02_440.2Hz"], modes.shapes[1])


def test_vtu_is_well_formed_and_compressed(box_modes: Box, tmp_path: Path) -> None:
    modes = box_modes("tetra", [np.zeros_like], grid=(20, 20, 20))
    write_modes_vtk(modes, tmp_path / "modes.vtu")
    root = ET.parse(tmp_path / "modes.vtu").getroot()
    assert root.get("compressor") == "vtkZLibDataCompressor"
    assert (tmp_path / "modes.vtu").stat().st_size < modes.shapes.nbytes + modes.points.nbytes


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_same_modes_same_bytes(modes: Modes, tmp_path: Path, suffix: str) -> None:
    for name in ("a", "b"):
        write_modes_vtk(modes, tmp_path / f"{name}{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("name", ["modes.xdmf", "modes", "modes.vtu.gz"])
def test_other_suffixes_are_refused(modes: Modes, tmp_path: Path, name: str) -> None:
    with pytest.raises(DefoError, match=r"is not one of \.vtu, \.vtk"):
        write_modes_vtk(modes, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_suffix_may_be_capital_and_folder_must_exist(modes: Modes, tmp_path: Path) -> None:
    assert check_vtk_path(tmp_path / "MODES.VTU") == ".vtu"
    with pytest.raises(DefoError, match="does not exist"):
        check_vtk_path(tmp_path / "absent" / "modes.vtu")


def test_interrupted_writer_leaves_the_old_file(
    modes: Modes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "modes.vtu"
    path.write_text("old")

    def interrupt(*args: object) -> bytes:
        raise KeyboardInterrupt

    monkeypatch.setattr(vtk_xml.zlib, "compress", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_modes_vtk(modes, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_export_loads_neither_pyvista_nor_meshio() -> None:
    script = (
        "import sys, fenics_defo.view\n"
        "sys.exit(' '.join({'pyvista', 'vtk', 'vtkmodules', 'meshio'} & set(sys.modules)) or 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], check=False)
    assert done.returncode == 0
