"""The legacy file format of VTK for unstructured grids (``.vtk``), version 4.2, binary.

Numbers are big-endian; names must not hold white space. Source: VTK file formats, simple legacy
formats, docs.vtk.org.
"""

from collections.abc import Mapping
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

_TYPES = {"f8": "double", "i8": "long", "i4": "int"}


def write_legacy(
    file: BinaryIO,
    *,
    points: NDArray[np.float64],
    cells: NDArray[np.int64],
    vtk_cell_type: int,
    point_data: Mapping[str, NDArray[Any]],
    field_data: Mapping[str, NDArray[Any]],
) -> None:
    """Write one grid of one cell type; arguments as `vtk_xml.write_xml`."""
    count, width = cells.shape
    file.write(b"# vtk DataFile Version 4.2\nvibration modes\nBINARY\nDATASET UNSTRUCTURED_GRID\n")
    _write_fields(file, field_data)
    file.write(f"POINTS {len(points)} double\n".encode())
    _write_numbers(file, points)
    file.write(f"CELLS {count} {count * (width + 1)}\n".encode())
    _write_numbers(file, np.insert(cells, 0, width, axis=1).astype(np.int32))
    file.write(f"CELL_TYPES {count}\n".encode())
    _write_numbers(file, np.full(count, vtk_cell_type, dtype=np.int32))
    file.write(f"POINT_DATA {len(points)}\n".encode())
    _write_fields(file, point_data)


def _write_fields(file: BinaryIO, fields: Mapping[str, NDArray[Any]]) -> None:
    file.write(f"FIELD FieldData {len(fields)}\n".encode())
    for name, array in fields.items():
        components = array.shape[1] if array.ndim == 2 else 1
        kind = _TYPES[array.dtype.str[1:]]
        file.write(f"{name} {components} {len(array)} {kind}\n".encode())
        _write_numbers(file, array)


def _write_numbers(file: BinaryIO, array: NDArray[Any]) -> None:
    file.write(np.ascontiguousarray(array, dtype=array.dtype.newbyteorder(">")).tobytes())
    file.write(b"\n")
