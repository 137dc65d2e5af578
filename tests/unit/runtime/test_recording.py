"""Tables and series that grow: what has been written stays, whole, whatever happens next."""

import errno
import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.runtime.recording import CsvTable, FrameMesh, FrameSeries

TET = FrameMesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]),
    np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
    "tetra",
)


def full_disk(*_: Any) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_rows_give_the_same_floats_back(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).standard_normal((5, 3)) * 10.0 ** np.arange(-9, 6)[:3]
    table = CsvTable(tmp_path / "t.csv", ["a", "b", "c"])
    for row in rows:
        table.append(row)
        assert (tmp_path / "t.csv").stat().st_size == table.size  # nothing waits in a buffer
    table.sync()
    table.close()
    assert (tmp_path / "t.csv").read_text().splitlines()[0] == "a,b,c"
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "t.csv", delimiter=",", skiprows=1), rows)


def test_a_table_goes_on_where_it_is_told(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    table = CsvTable(path, ["a"])
    table.append([1.0])
    kept = table.size
    table.append([2.0])
    table.close()
    again = CsvTable(path, ["a"], size=kept)
    again.append([3.0])
    again.close()
    assert path.read_text() == "a\n1.0\n3.0\n"
    with pytest.raises(FileFormatError, match="not the table"):
        CsvTable(path, ["b"], size=kept)
    with pytest.raises(FileFormatError, match="not the table"):
        CsvTable(path, ["a"], size=1000)
    assert path.read_text() == "a\n1.0\n3.0\n"


def test_a_full_disk_leaves_whole_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "t.csv"
    table = CsvTable(path, ["a"])
    table.append([1.0])
    real, calls = os.pwrite, []

    def half(file: int, data: bytes, offset: int) -> int:
        calls.append(data)
        return real(file, data[:2], offset) if len(calls) == 1 else full_disk()

    monkeypatch.setattr(os, "pwrite", half)
    with pytest.raises(DefoError, match=r"t\.csv.*No space left"):
        table.append([2.0])
    monkeypatch.undo()
    assert path.read_text() == "a\n1.0\n"
    table.append([3.0])  # once there is room
    assert path.read_text() == "a\n1.0\n3.0\n"
    table.close()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_no_row_with_nan(tmp_path: Path, value: float) -> None:
    table = CsvTable(tmp_path / "t.csv", ["a", "b"])
    with pytest.raises(DefoError, match="diverged"):
        table.append([1.0, value])
    table.close()
    assert (tmp_path / "t.csv").read_text() == "a,b\n"


def test_a_table_without_a_place(tmp_path: Path) -> None:
    with pytest.raises(DefoError, match="cannot be written"):
        CsvTable(tmp_path / "nowhere" / "t.csv", ["a"])


def test_paraview_s_reader_opens_the_series(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "motion", TET)
    fields = [np.random.default_rng(i).standard_normal((5, 3)) for i in range(3)]
    for i, field in enumerate(fields):
        series.append(0.1 * i, {"displacement": field, "speed": field[:, 0]})
    reader = pyvista.get_reader(tmp_path / "motion.pvd")
    np.testing.assert_allclose(reader.time_values, [0.0, 0.1, 0.2])
    for i, field in enumerate(fields):
        reader.set_active_time_point(i)
        (grid,) = reader.read()
        np.testing.assert_array_equal(grid.points, TET.points)
        np.testing.assert_array_equal(grid.cells_dict[10], TET.cells)
        np.testing.assert_array_equal(grid.point_data["displacement"], field)
        np.testing.assert_array_equal(grid.point_data["speed"], field[:, 0])
        assert grid.field_data["TimeValue"] == [0.1 * i]


def named(folder: Path) -> list[str]:
    tree = ElementTree.parse(folder / "motion.pvd")
    return [item.attrib["file"] for item in tree.iter("DataSet")]


def test_a_series_goes_on_and_forgets_later_frames(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "motion", TET)
    for i in range(4):
        series.append(float(i), {"u": np.full((5, 3), float(i))})
    again = FrameSeries(tmp_path, "motion", TET, times=series.times[:2])
    assert len(named(tmp_path)) == 2
    assert len(list((tmp_path / "motion").iterdir())) == 2
    again.append(9.0, {"u": np.zeros((5, 3))})
    assert named(tmp_path) == [f"motion/frame_{i:06d}.vtu" for i in range(3)]
    (tmp_path / "motion" / "frame_000001.vtu").unlink()
    with pytest.raises(DefoError, match=r"frame_000001\.vtu: is missing"):
        FrameSeries(tmp_path, "motion", TET, times=again.times)


def test_a_full_disk_leaves_whole_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    series = FrameSeries(tmp_path, "motion", TET)
    series.append(0.0, {"u": np.zeros((5, 3))})
    for after in (0, 1):  # the disk is full at the frame, then at the index
        calls: list[int] = []
        real = os.fsync

        def fsync(file: int, calls: list[int] = calls, after: int = after) -> None:
            calls.append(file)
            real(file) if len(calls) <= after else full_disk()  # noqa: B023

        monkeypatch.setattr(os, "fsync", fsync)
        with pytest.raises(DefoError, match="No space left"):
            series.append(1.0, {"u": np.ones((5, 3))})
        monkeypatch.undo()
        assert series.times == (0.0,)
        assert named(tmp_path) == ["motion/frame_000000.vtu"]
    series.append(1.0, {"u": np.ones((5, 3))})
    assert pyvista.get_reader(tmp_path / "motion.pvd").time_values == [0.0, 1.0]


def test_no_frame_with_nan(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "motion", TET)
    with pytest.raises(DefoError, match="u holds NaN"):
        series.append(0.0, {"u": np.full((5, 3), np.nan)})
    assert list((tmp_path / "motion").iterdir()) == []
