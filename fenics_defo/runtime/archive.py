"""The container of our files: an ``.npz`` that NumPy opens, written and read with more care.

A file is an uncompressed zip archive with one ``.npy`` member for each array and one, ``header``,
whose single string is JSON: ``{"format", "kind", "version", "units"}``. ``np.load`` shows the
arrays directly. The layout of ``.npy`` is that of NEP 1 (numpy.lib.format).
"""

import json
import math
import os
import re
import struct
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.atomic import atomic_path

FORMAT = "fenics_defo"

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip archive can store
_LONGEST_HEADER = 4096  # bytes of a .npy header, characters of ours: generous for both
_NPY_HEADER = re.compile(
    r"\{'descr': '(?P<descr>[<>|][biufU]\d{1,5})', "
    r"'fortran_order': (?P<fortran>True|False), "
    r"'shape': \((?P<shape>(?:\d{1,18}, ?)*(?:\d{1,18})?)\), ?\} *\n"
)


class ArraySpec(NamedTuple):
    """What `read_archive` demands of one array.

    Args:
        kinds: allowed ``dtype.kind`` letters, for instance ``"f"`` or ``"iu"``.
        ndim: number of axes.
    """

    kinds: str
    ndim: int


def write_archive(
    path: str | os.PathLike[str],
    arrays: Mapping[str, NDArray[Any]],
    *,
    kind: str,
    version: int,
    units: Mapping[str, str],
) -> None:
    """Write ``arrays`` to ``path``: the same input gives the same bytes, all of them or none.

    Args:
        path: file to create or to replace, see `atomic_path`.
        arrays: name -> array of booleans, integers, floats or strings, stored in this order,
            little-endian and in C order.
        kind: what the file holds, for instance ``"modes"``.
        version: number of the layout of this kind, raised when old readers would misread it.
        units: name -> SI unit of the arrays that have one.

    Raises:
        ValueError: an array of objects or other types that are not plain numbers or text, or text
            with half a surrogate pair.
        DefoError: the file cannot be written.
    """
    header = {"format": FORMAT, "kind": kind, "version": version, "units": dict(units)}
    members = {"header": np.array(json.dumps(header, sort_keys=True, ensure_ascii=False))}
    for name, array in arrays.items():
        members[name] = _plain(name, array)
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, array in members.items():
            info = zipfile.ZipInfo(f"{name}.npy", date_time=_EPOCH)
            info.create_system = 3  # otherwise the archive would name the operating system
            info.file_size = array.nbytes + _LONGEST_HEADER  # lets zipfile choose ZIP64
            with archive.open(info, "w") as member:
                np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)


def _plain(name: str, array: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(array)
    if name == "header" or array.dtype.kind not in "biufU":
        raise ValueError(f"array {name!r} of type {array.dtype} cannot be stored")
    plain: NDArray[Any] = np.asarray(array, dtype=array.dtype.newbyteorder("<"), order="C")
    if plain.dtype.kind == "U":
        _check_letters(name, np.frombuffer(plain.tobytes(), dtype="<u4"))
    return plain


def read_archive(
    path: str | os.PathLike[str],
    *,
    kind: str,
    version: int,
    required: Mapping[str, ArraySpec],
) -> dict[str, NDArray[Any]]:
    """Read the arrays that `write_archive` wrote, trusting nothing in the file.

    Nothing is unpickled, and no size that the file declares is believed before it is compared
    with the size of the file: members are stored uncompressed, so a small file cannot ask for
    much memory.

    Args:
        path: file to read.
        kind: what the file must hold.
        version: newest layout that the caller understands.
        required: name -> what the array must be; other arrays in the file are not read.

    Returns:
        name -> array, read-only, in the order of ``required``; floats are finite.

    Raises:
        FileFormatError: the file is missing, damaged, of another kind or a newer version, or an
            array is missing or not as required.
    """
    with _opened(path) as archive:
        _check_header(path, archive, kind, version)
        return {name: _read_required(path, archive, name, required[name]) for name in required}


def archive_kind(path: str | os.PathLike[str]) -> str:
    """What a file of ours holds, for instance ``"modes"``; only its header is read.

    Raises:
        FileFormatError: the file is missing, damaged or not ours.
    """
    with _opened(path) as archive:
        return str(_read_header(path, archive).get("kind"))


@contextmanager
def _opened(path: str | os.PathLike[str]) -> Iterator[zipfile.ZipFile]:
    """Open an archive; whatever is wrong with it becomes one sentence."""
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except FileFormatError:
        raise
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror or error}.") from error
    # What zipfile raises for damaged, encrypted and unknown archives, and absurd numbers in them.
    except (
        zipfile.BadZipFile,
        EOFError,
        NotImplementedError,
        OverflowError,
        RuntimeError,
        ValueError,
        struct.error,
    ) as error:
        raise FileFormatError(
            f"{path}: is damaged or not a file of {FORMAT} ({error}); write it again."
        ) from error


def _check_header(
    path: str | os.PathLike[str], archive: zipfile.ZipFile, kind: str, version: int
) -> None:
    """Refuse what is of another kind or from a newer version of this package."""
    header = _read_header(path, archive)
    if header.get("kind") != kind:
        raise FileFormatError(f"{path}: holds {header.get('kind')!r}, expected {kind!r}.")
    found = header.get("version")
    if type(found) is not int or found < 1:
        raise ValueError(f"version {found!r}")
    if found > version:
        raise FileFormatError(
            f"{path}: has version {found} of the format of {kind!r}, this {FORMAT} reads up to "
            f"version {version}; update {FORMAT}."
        )


def _read_header(path: str | os.PathLike[str], archive: zipfile.ZipFile) -> dict[str, Any]:
    """The header, if it is one of ours."""
    members = [info.filename for info in archive.infolist()]
    if "header.npy" not in members:
        raise FileFormatError(f"{path}: has no header, it was not written by {FORMAT}.")
    if len(set(members)) < len(members):
        raise FileFormatError(f"{path}: holds two arrays of one name; write it again.")
    text = _read_member(archive, "header")
    if text.dtype.kind != "U" or text.ndim != 0 or len(str(text)) > _LONGEST_HEADER:
        raise ValueError("the header is not a short text")
    header = json.loads(str(text))
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise FileFormatError(f"{path}: was not written by {FORMAT}.")
    return header


def _read_required(
    path: str | os.PathLike[str], archive: zipfile.ZipFile, name: str, spec: ArraySpec
) -> NDArray[Any]:
    """Read one array and compare it with what is required of it."""
    if f"{name}.npy" not in archive.namelist():
        raise FileFormatError(f"{path}: the array {name!r} is missing; write the file again.")
    array = _read_member(archive, name)
    if array.dtype.kind not in spec.kinds or array.ndim != spec.ndim:
        raise FileFormatError(
            f"{path}: the array {name!r} has type {array.dtype} and {array.ndim} axes, expected "
            f"kind {spec.kinds!r} and {spec.ndim} axes."
        )
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise FileFormatError(f"{path}: the array {name!r} holds values that are not finite.")
    return array


def _read_member(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """Read one ``.npy`` member; its checksum is verified by zipfile."""
    info = archive.getinfo(f"{name}.npy")
    if info.compress_type != zipfile.ZIP_STORED or info.file_size != info.compress_size:
        raise ValueError(f"{name!r} is compressed, which files of {FORMAT} never are")
    assert archive.fp is not None  # open as long as the caller's with statement
    if info.file_size > os.fstat(archive.fp.fileno()).st_size:
        raise ValueError(f"{name!r} claims to be larger than the file")
    return _parse_npy(archive.read(info), name)


def _parse_npy(data: bytes, name: str) -> NDArray[Any]:
    """Turn the bytes of a ``.npy`` file into an array that looks into them.

    The header is matched, not evaluated, and only plain number and text types match.
    """
    if data[:8] != b"\x93NUMPY\x01\x00":
        raise ValueError(f"{name!r} is not an array in version 1.0 of the .npy format")
    begin = 10 + int.from_bytes(data[8:10], "little")
    match = _NPY_HEADER.fullmatch(data[10 : min(begin, _LONGEST_HEADER)].decode("latin-1"))
    if match is None:
        raise ValueError(f"{name!r} holds no plain numbers or text")
    try:
        dtype = np.dtype(match["descr"])
    except TypeError as error:
        raise ValueError(f"{name!r} has the unknown type {match['descr']!r}") from error
    shape = tuple(int(extent) for extent in match["shape"].split(",") if extent.strip())
    if dtype.itemsize == 0 or math.prod(shape) * dtype.itemsize != len(data) - begin:
        raise ValueError(f"{name!r} has {len(data) - begin} bytes, not those of its shape {shape}")
    if dtype.kind == "U":
        _check_letters(name, np.frombuffer(data, dtype=f"{match['descr'][0]}u4", offset=begin))
    order: Literal["C", "F"] = "F" if match["fortran"] == "True" else "C"
    return np.ndarray(shape, dtype, buffer=data, offset=begin, order=order)


def _check_letters(name: str, codes: NDArray[np.uint32]) -> None:
    """Refuse numbers that are no letters: Python's own text functions fail on them in odd ways."""
    if not ((codes < 0xD800) | ((codes > 0xDFFF) & (codes <= 0x10FFFF))).all():
        raise ValueError(f"{name!r} holds letters that do not exist")
