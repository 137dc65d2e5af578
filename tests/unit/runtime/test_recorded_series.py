"""A recorded series reads back as it was written, or says in one sentence why it does not."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.recording import FrameMesh, FrameSeries, read_frame, read_series

POINTS = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
MESH = FrameMesh(POINTS, np.array([(0, 1, 2, 3), (1, 2, 3, 4)]), "tetra")


def fields(number):
    rng = np.random.default_rng(number)
    return {"displacement": rng.standard_normal((5, 3)), "heat": rng.standard_normal(5)}


@pytest.fixture
def folder(tmp_path):
    series = FrameSeries(tmp_path, "motion", MESH)
    for number, time in enumerate((0.0, 1e-5, 0.25)):
        series.append(time, fields(number))
    return tmp_path


def test_what_was_written_is_read(folder):
    for path in (folder, str(folder), folder / "motion.pvd"):
        series = read_series(path)
        assert series.size == 3
        assert series.times.tolist() == [0.0, 1e-5, 0.25]
        assert (series.points == POINTS).all()
        for number in range(3):
            found = series.frame(number)
            for name, values in fields(number).items():
                assert (found[name] == values).all()
    found = read_frame(folder / "motion" / "frame_000001.vtu")
    assert found["TimeValue"] == 1e-5
    assert found["connectivity"].tolist() == MESH.cells.ravel().tolist()
    assert found["types"].dtype == np.uint8


def change(path, old, new):
    path.write_bytes(path.read_bytes().replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"Collection", b"Selection", "is no index of a series"),
        (b'part="0"', b'part="1"', "is no index of a series"),
        (b'"0.25"', b'"1e999"', "is no index of a series"),
        (b'"0.25"', b'"0.2.5"', "is no index of a series"),
        (b"motion/frame", b"other/frame", None),
        (b"motion/frame_000002", b"motion/../../secret", "is no index of a series"),
        (b"motion/frame", b"../frame", "is no index of a series"),
        (b"motion/frame", b"/etc/../frame", "is no index of a series"),
        (b"<DataSet", b"<Dataset", "holds no frame"),
        (b"<Coll", b"\xff\xfe", "is damaged"),
    ],
)
def test_an_index_that_is_not_ours(folder, old, new, message):
    change(folder / "motion.pvd", old, new)
    if message is None:  # a folder of another name is missing, no more
        with pytest.raises(FileFormatError, match="cannot be read"):
            read_series(folder).frame(0)
        return
    with pytest.raises(FileFormatError, match=message):
        read_series(folder)


def test_missing_files(folder):
    with pytest.raises(FileFormatError, match=r"other\.pvd: cannot be read .*name the folder"):
        read_series(folder, "other")
    (folder / "motion" / "frame_000001.vtu").unlink()
    series = read_series(folder)
    assert (series.frame(2)["displacement"] == fields(2)["displacement"]).all()
    with pytest.raises(FileFormatError, match=r"frame_000001\.vtu: cannot be read"):
        series.frame(1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"UnstructuredGrid", b"StructuredGrid", "it is no frame"),
        (b'"Float64" Name="displacement"', b'"Float99" Name="displacement"', "type Float99"),
        (b'Name="displacement" ', b'Name="displaced" ', "no displacement"),
        (b'Name="Points"', b'Name="Nodes"', "it has no points"),
        (b'offset="0"', b'offset="99999"', "TimeValue is not as long as it says"),
        (b'offset="0"', b'offset="-8"', "not declared as they should"),
        (b'NumberOfComponents="3"/>\n</PointData', b'NumberOfComponents="0"/>\n</P', "as long"),
        (np.float64(1e-5).tobytes(), np.float64(np.inf).tobytes(), "TimeValue .* not finite"),
    ],
)
def test_a_frame_that_is_not_ours(folder, old, new, message):
    path = folder / "motion" / "frame_000001.vtu"
    if b"</PointData" in old:  # of the last array, which is a scalar: the one before it
        old, new = b'Components="3"/>\n<DataArray', b'Components="0"/>\n<DataArray'
    before = path.read_bytes()
    change(path, old, new)
    assert path.read_bytes() != before
    with pytest.raises(FileFormatError, match=message):
        read_series(folder).frame(1)


@given(data=st.data())
def test_damage_is_found_or_harmless(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("damaged")
    FrameSeries(folder, "motion", MESH).append(0.5, fields(0))
    path = folder / data.draw(st.sampled_from(["motion.pvd", "motion/frame_000000.vtu"]))
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        frame = read_series(folder).frame(0)
    except FileFormatError as error:
        sentence = str(error)
    else:
        sentence = "It is harmless."
        assert np.isfinite(frame["displacement"]).all()
    assert re.fullmatch(r"[^\n]{10,400}\.", sentence)
