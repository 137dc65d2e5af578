"""One frame of a time series: the XML format of VTK (``.vtu``) with its arrays appended raw.

After ``_`` the arrays follow, each preceded by its length in bytes as UInt64; ``offset`` counts
from there. Nothing is compressed: digits of floating-point numbers hardly are, and frames are
written while a computation waits. Source: VTK file formats, XML file formats, docs.vtk.org.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError

VTK_CELL_TYPES = {"tetra": 10, "hexahedron": 12, "tetra10": 24, "hexahedron27": 29}
"""Numbers of our cell types in VTK (vtkCellType.h)."""

_HEAD = b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
_APPENDED = b'<AppendedData encoding="raw">\n_'
_LONGEST_HEAD = 65536  # bytes before the arrays: generous
_DECLARED = re.compile(
    r'<DataArray type="(?P<type>[A-Z][A-Za-z0-9]{3,7})" Name="(?P<name>[^"&]{1,200})" '
    r'format="appended" offset="(?P<offset>\d{1,15})"'
    r'(?: NumberOfTuples="\d{1,15}")?(?: NumberOfComponents="(?P<width>\d{1,4})")?/>'
)
_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}


@dataclass(frozen=True)
class FrameMesh:
    """What all frames of a series have in common.

    Args:
        points: nodes at rest (n, 3) [m].
        cells: (m, c) rows of ``points``, in the node order of VTK.
        cell_type: one of `VTK_CELL_TYPES`.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    cell_type: str

    @cached_property
    def cell_arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays of the cells as files hold them."""
        count, width = self.cells.shape
        # Half the size, where the rows fit.
        kind = np.int32 if self.cells.size < 2**31 else np.int64
        return {
            "connectivity": self.cells.ravel().astype(kind),
            "offsets": (np.arange(1, count + 1) * width).astype(kind),
            "types": np.full(count, VTK_CELL_TYPES[self.cell_type], np.uint8),
        }


def write_frame(
    file: BinaryIO, mesh: FrameMesh, *, time: float, point_data: Mapping[str, NDArray[np.float64]]
) -> None:
    """Write one frame.

    Args:
        file: open for writing bytes.
        mesh: nodes at rest and cells.
        time: of the frame [s].
        point_data: name -> (n,) or (n, d) values at the nodes.
    """
    blocks: list[bytes] = []
    offset = 0

    def declared(name: str, array: NDArray[Any], attributes: str = "") -> bytes:
        nonlocal offset
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        data = little.tobytes()
        if array.ndim == 2:
            attributes += f' NumberOfComponents="{array.shape[1]}"'
        text = (
            f'<DataArray type="{_TYPES[array.dtype.str[1:]]}" Name={quoteattr(name)} '
            f'format="appended" offset="{offset}"{attributes}/>\n'
        )
        blocks.extend((np.uint64(len(data)).astype("<u8").tobytes(), data))
        offset += 8 + len(data)
        return text.encode()

    file.write(
        b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
        b'byte_order="LittleEndian" header_type="UInt64">\n<UnstructuredGrid>\n<FieldData>\n'
    )
    file.write(declared("TimeValue", np.array([time]), ' NumberOfTuples="1"'))
    count = f'NumberOfPoints="{len(mesh.points)}" NumberOfCells="{len(mesh.cells)}"'
    file.write(f"</FieldData>\n<Piece {count}>\n<Points>\n".encode())
    file.write(declared("Points", mesh.points))
    file.write(b"</Points>\n<Cells>\n")
    file.writelines([declared(name, array) for name, array in mesh.cell_arrays.items()])
    file.write(b"</Cells>\n<PointData>\n")
    file.writelines([declared(name, array) for name, array in point_data.items()])
    file.write(
        b"</PointData>\n</Piece>\n</UnstructuredGrid>\n"
        b'<AppendedData encoding="raw">\n_' + b"".join(blocks) + b"\n</AppendedData>\n</VTKFile>\n"
    )


def read_frame(path: str | os.PathLike[str]) -> dict[str, NDArray[Any]]:
    """Read the arrays of a frame that `write_frame` wrote, in whatever state the file is.

    Returns:
        name -> array; floats are finite; "Points" (n, 3) is one of them.

    Raises:
        FileFormatError: the file is missing, damaged, or not of this package.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror or error}).") from error
    begin = data.find(_APPENDED, 0, _LONGEST_HEAD)
    try:
        if not data.startswith(_HEAD) or begin < 0:
            raise ValueError("it is no frame of fenics_defo")
        head, start = data[:begin].decode("utf-8"), begin + len(_APPENDED)
        found = list(_DECLARED.finditer(head))
        if len(found) != head.count("<DataArray"):
            raise ValueError("its arrays are not declared as they should be")
        arrays = {match["name"]: _array(data, start, match) for match in found}
        if arrays.get("Points", np.empty(0)).shape[1:] != (3,):
            raise ValueError("it has no points")
    except ValueError as error:  # text that is no UTF-8 is one of them
        raise FileFormatError(f"{path}: is damaged ({error}); record it again.") from error
    return arrays


def _array(data: bytes, start: int, match: re.Match[str]) -> NDArray[Any]:
    """One of the arrays after ``start``; its size is compared with that of the file."""
    kinds = {vtk: np.dtype("<" + kind) for kind, vtk in _TYPES.items()}
    if match["type"] not in kinds:
        raise ValueError(f"{match['name']} has the unknown type {match['type']}")
    kind, width = kinds[match["type"]], int(match["width"] or 1)
    begin = start + int(match["offset"]) + 8
    size = int.from_bytes(data[begin - 8 : begin], "little")
    if begin + size > len(data) or width == 0 or size % (width * kind.itemsize):
        raise ValueError(f"{match['name']} is not as long as it says")
    array = np.frombuffer(data, kind, count=size // kind.itemsize, offset=begin)
    if kind.kind == "f" and not np.isfinite(array).all():
        raise ValueError(f"{match['name']} holds values that are not finite")
    return array.reshape(-1, width) if match["width"] else array
