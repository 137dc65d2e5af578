"""One frame of a time series: the XML format of VTK (``.vtu``) with its arrays appended raw.

After ``_`` the arrays follow, each preceded by its length in bytes as UInt64; ``offset`` counts
from there. Nothing is compressed: digits of floating-point numbers hardly are, and frames are
written while a computation waits. Source: VTK file formats, XML file formats, docs.vtk.org.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

VTK_CELL_TYPES = {"tetra": 10, "hexahedron": 12, "tetra10": 24, "hexahedron27": 29}
"""Numbers of our cell types in VTK (vtkCellType.h)."""

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
