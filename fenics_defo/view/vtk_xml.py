"""The XML file format of VTK for unstructured grids (``.vtu``), written array by array.

Arrays are inline base64 of zlib blocks, each array preceded by its own base64 header of UInt64:
number of blocks, size of a block, size of the last block if it is partial (else 0), compressed
size of each block. Source: VTK file formats, XML file formats, docs.vtk.org.
"""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

_BLOCK = 1 << 20
_LEVEL = 1  # digits of floating-point numbers hardly compress: higher levels only take longer
_TYPES = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}


def write_xml(
    file: BinaryIO,
    *,
    points: NDArray[np.float64],
    cells: NDArray[np.int64],
    vtk_cell_type: int,
    point_data: Mapping[str, NDArray[Any]],
    field_data: Mapping[str, NDArray[Any]],
) -> None:
    """Write one grid of one cell type.

    Args:
        file: open for writing bytes.
        points: (n, 3).
        cells: (m, c) zero-based, in the node order of VTK.
        vtk_cell_type: number of the cell type in VTK.
        point_data: name -> (n,) or (n, d) of float64 or int64.
        field_data: name -> (k,) of float64 or int64.
    """
    count, width = cells.shape
    file.write(
        b'<?xml version="1.0"?>\n'
        b'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        b'header_type="UInt64" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n'
    )
    file.write(b"<FieldData>\n")
    for name, array in field_data.items():
        _write_array(file, name, array, f' NumberOfTuples="{len(array)}"')
    file.write(b"</FieldData>\n")
    file.write(f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">\n'.encode())
    file.write(b"<Points>\n")
    _write_array(file, "Points", points)
    file.write(b"</Points>\n<Cells>\n")
    _write_array(file, "connectivity", cells.ravel())
    _write_array(file, "offsets", np.arange(1, count + 1) * width)
    _write_array(file, "types", np.full(count, vtk_cell_type, dtype=np.uint8))
    file.write(b"</Cells>\n<PointData>\n")
    for name, array in point_data.items():
        _write_array(file, name, array)
    file.write(b"</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _write_array(file: BinaryIO, name: str, array: NDArray[Any], attributes: str = "") -> None:
    kind = array.dtype.str[1:]
    if array.ndim == 2:
        attributes += f' NumberOfComponents="{array.shape[1]}"'
    file.write(
        f"<DataArray type={quoteattr(_TYPES[kind])} Name={quoteattr(name)} "
        f'format="binary"{attributes}>\n'.encode()
    )
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    data = memoryview(little.reshape(-1).view(np.uint8))
    blocks = [zlib.compress(data[i : i + _BLOCK], _LEVEL) for i in range(0, len(data), _BLOCK)]
    header = [len(blocks), _BLOCK, len(data) % _BLOCK, *map(len, blocks)]
    file.write(base64.b64encode(np.array(header, dtype="<u8").tobytes()))
    file.write(base64.b64encode(b"".join(blocks)))
    file.write(b"\n</DataArray>\n")
