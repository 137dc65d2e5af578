import io
import pickle
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime import ArraySpec, read_archive, write_archive

ARRAYS = {
    "numbers": np.linspace(0.0, 1.0, 12).reshape(3, 4),
    "counts": np.arange(7, dtype=np.int64),
    "flag": np.array(True),
    "word": np.array("tetra"),
    "nothing": np.zeros((0, 3)),
}
SPECS = {
    "numbers": ArraySpec("f", 2),
    "counts": ArraySpec("iu", 1),
    "flag": ArraySpec("b", 0),
    "word": ArraySpec("U", 0),
    "nothing": ArraySpec("f", 2),
}
HEADER = '{"format": "fenics_defo", "kind": "test", "version": 1}'


def write(path: Path, arrays: dict[str, NDArray[Any]] = ARRAYS, **changes: Any) -> Path:
    write_archive(path, arrays, **({"kind": "test", "version": 1, "units": {}} | changes))
    return path


def read(path: Path, specs: dict[str, ArraySpec] = SPECS) -> dict[str, NDArray[Any]]:
    return read_archive(path, kind="test", version=1, required=specs)


def forge(path: Path, members: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> Path:
    """Write a zip archive with a valid header and any members."""
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("header.npy", npy(np.array(HEADER)))
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def npy(array: NDArray[Any], allow_pickle: bool = False) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=allow_pickle)
    return buffer.getvalue()


def npy_text(header: str, data: bytes = b"") -> bytes:
    text = header.encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


def test_round_trip_is_bitwise(tmp_path: Path) -> None:
    found = read(write(tmp_path / "a.npz"))
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert found[name].dtype == array.dtype
        assert found[name].shape == array.shape
        assert found[name].tobytes() == array.tobytes()
        assert not found[name].flags.writeable


def test_plain_numpy_opens_it(tmp_path: Path) -> None:
    with np.load(write(tmp_path / "a.npz", units={"numbers": "m"})) as archive:
        np.testing.assert_array_equal(archive["numbers"], ARRAYS["numbers"])
        assert '"units": {"numbers": "m"}' in str(archive["header"])


def test_same_input_gives_same_bytes(tmp_path: Path) -> None:
    first = write(tmp_path / "a.npz", units={"numbers": "m", "counts": "1"})
    second = write(tmp_path / "b.npz", units={"counts": "1", "numbers": "m"})
    assert first.read_bytes() == second.read_bytes()


def test_layout_and_byte_order_of_the_input_do_not_matter(tmp_path: Path) -> None:
    numbers = ARRAYS["numbers"]
    first = write(tmp_path / "a.npz", {"numbers": numbers})
    for other in (np.asfortranarray(numbers), numbers.astype(">f8"), np.repeat(numbers, 2, 0)[::2]):
        second = write(tmp_path / "b.npz", {"numbers": other})
        assert first.read_bytes() == second.read_bytes()


def test_what_numpy_saves_again_is_read(tmp_path: Path) -> None:
    with np.load(write(tmp_path / "a.npz")) as archive:
        members = {name: archive[name] for name in archive.files}
    members["numbers"] = np.asfortranarray(members["numbers"])
    np.savez(tmp_path / "b.npz", **members)
    np.testing.assert_array_equal(read(tmp_path / "b.npz")["numbers"], ARRAYS["numbers"])


def test_objects_are_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'numbers' of type object"):
        write(tmp_path / "a.npz", {"numbers": np.array([None])})
    assert list(tmp_path.iterdir()) == []


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="No such file"):
        read(tmp_path / "absent.npz")
    with pytest.raises(FileFormatError, match="Is a directory"):
        read(tmp_path)


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x05\x06" + 18 * b"\x00", b"PK" * 500])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match=r"a\.npz: "):
        read(path)


def test_archives_of_others_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", numbers=np.ones(3))
    with pytest.raises(FileFormatError, match="was not written by fenics_defo"):
        read(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", header=np.array('{"format": "other"}'))
    with pytest.raises(FileFormatError, match="was not written by fenics_defo"):
        read(tmp_path / "b.npz")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "model"}, "holds 'model', expected 'test'"),
        ({"version": 2}, "has version 2 .* up to version 1; update"),
        ({"version": 0}, "version 0"),
        ({"version": True}, "version True"),
    ],
)
def test_other_kinds_and_versions_are_refused(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    path = write(tmp_path / "a.npz", **changes)
    with pytest.raises(FileFormatError, match=message):
        read(path)


def test_older_version_is_read(tmp_path: Path) -> None:
    path = write(tmp_path / "a.npz")
    found = read_archive(path, kind="test", version=3, required={"word": ArraySpec("U", 0)})
    assert str(found["word"]) == "tetra"


@pytest.mark.parametrize(
    "header",
    [np.array("[1"), np.array("[" * 4000), np.array("[]"), np.ones(2), np.array("x" * 5000)],
)
def test_broken_headers_are_refused(tmp_path: Path, header: NDArray[Any]) -> None:
    np.savez(tmp_path / "a.npz", header=header)
    with pytest.raises(FileFormatError, match=r"a\.npz: "):
        read(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.ones(3), "expected kind 'f' and 2 axes"),
        (np.ones((3, 4), dtype=int), "has type int64"),
        (np.ones((3, 4), dtype=complex), "plain numbers"),
        (np.full((3, 4), np.nan), "not finite"),
        (np.full((3, 4), np.inf), "not finite"),
    ],
)
def test_wrong_arrays_are_named(tmp_path: Path, array: NDArray[Any], message: str) -> None:
    path = forge(tmp_path / "a.npz", {"numbers.npy": npy(array)})
    with pytest.raises(FileFormatError, match=f"'numbers' .*{message}"):
        read(path, {"numbers": SPECS["numbers"]})


def test_missing_array_is_named(tmp_path: Path) -> None:
    path = forge(tmp_path / "a.npz", {})
    with pytest.raises(FileFormatError, match="'numbers' is missing"):
        read(path)


class Bomb:
    """Would create a file if anything unpickled it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        return (Path.touch, (self.path,))


def test_object_arrays_are_not_unpickled(tmp_path: Path) -> None:
    exploded = tmp_path / "exploded"
    hostile = npy(np.array([[Bomb(exploded)]], dtype=object), allow_pickle=True)
    pickle.loads(hostile[hostile.index(b"\n") + 1 :])  # the bomb does work
    assert exploded.exists()
    exploded.unlink()
    path = forge(tmp_path / "a.npz", {"numbers.npy": hostile})
    with pytest.raises(FileFormatError, match="no plain numbers"):
        read(path, {"numbers": SPECS["numbers"]})
    assert not exploded.exists()


@pytest.mark.parametrize(
    "member",
    [
        npy_text("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 9), }"),
        npy_text("{'descr': '<f8', 'fortran_order': False, 'shape': (1, -1), }", 8 * b"\0"),
        npy_text("{'descr': '<f3', 'fortran_order': False, 'shape': (1, 1), }", 3 * b"\0"),
        npy_text("{'descr': '<U0', 'fortran_order': False, 'shape': (1, 1), }"),
        npy_text("__import__('os').abort()"),
        npy_text("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1, 1), }", 8 * b"\0"),
        b"\x93NUMPY\x01\x00\xff\xff{",
        b"\x93NUMPY\x02\x00" + npy(np.ones((1, 1)))[8:],
        b"\x93NUM",
        b"",
    ],
)
def test_hostile_array_headers_are_refused(tmp_path: Path, member: bytes) -> None:
    path = forge(tmp_path / "a.npz", {"numbers.npy": member})
    with pytest.raises(FileFormatError, match=r"a\.npz: "):
        read(path, {"numbers": SPECS["numbers"]})


@pytest.mark.parametrize("code", [0xD800, 0xDFFF, 0x110000, 0x7FFFFFFF, 0xFFFFFFFF])
@pytest.mark.parametrize("order", "<>")
def test_letters_that_do_not_exist_are_refused(tmp_path: Path, code: int, order: str) -> None:
    """NumPy stores letters as 32-bit numbers and makes texts of any of them."""
    text = f"{{'descr': '{order}U1', 'fortran_order': False, 'shape': (), }}"
    path = forge(tmp_path / "a.npz", {"word.npy": npy_text(text, struct.pack(f"{order}I", code))})
    with pytest.raises(FileFormatError, match="'word' holds letters that do not exist"):
        read(path, {"word": SPECS["word"]})


def test_half_a_letter_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'word' holds letters that do not exist"):
        write(tmp_path / "a.npz", {"word": np.array("a\ud800")})
    assert list(tmp_path.iterdir()) == []


def test_compressed_members_are_refused_before_they_are_inflated(tmp_path: Path) -> None:
    bomb = {"numbers.npy": npy(np.zeros((1000, 1000)))}
    path = forge(tmp_path / "a.npz", bomb, zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 20_000
    with pytest.raises(FileFormatError, match="is compressed"):
        read(path, {"numbers": SPECS["numbers"]})


def test_declared_sizes_are_not_believed(tmp_path: Path) -> None:
    path = forge(tmp_path / "a.npz", {"numbers.npy": npy(np.ones((1, 1)))})
    data = bytearray(path.read_bytes())
    entry = data.rindex(b"PK\x01\x02")
    struct.pack_into("<II", data, entry + 20, 2**31, 2**31)  # both sizes in the central directory
    path.write_bytes(data)
    with pytest.raises(FileFormatError, match="larger than the file"):
        read(path, {"numbers": SPECS["numbers"]})


@pytest.mark.filterwarnings("error")
def test_two_arrays_of_one_name_are_refused(tmp_path: Path) -> None:
    path = forge(tmp_path / "a.npz", {"one.npy": npy(np.ones(1)), "two.npy": npy(np.ones(1))})
    path.write_bytes(path.read_bytes().replace(b"two.npy", b"one.npy"))
    with pytest.raises(FileFormatError, match="two arrays of one name"):
        read(path)


def outcome(path: Path) -> dict[str, bytes] | None:
    """Bytes of what is read, or None after a FileFormatError; no other exception passes."""
    message = ""
    try:
        return {name: array.tobytes() for name, array in read(path).items()}
    except FileFormatError as error:
        message = str(error)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return None


def test_no_truncated_file_is_read(tmp_path: Path) -> None:
    path = write(tmp_path / "a.npz")
    data = path.read_bytes()
    for length in range(0, len(data), 7):
        path.write_bytes(data[:length])
        assert outcome(path) is None


def test_flipped_bytes_are_found_or_harmless(tmp_path: Path) -> None:
    path = write(tmp_path / "a.npz")
    data = path.read_bytes()
    intact = outcome(path)
    assert intact is not None
    rng = np.random.default_rng(11)
    refused = 0
    for position in range(0, len(data), 2):
        damaged = bytearray(data)
        damaged[position] ^= int(rng.integers(1, 256))
        path.write_bytes(damaged)
        found = outcome(path)
        assert found in (None, intact)
        refused += found is None
    assert refused > len(data) // 4
