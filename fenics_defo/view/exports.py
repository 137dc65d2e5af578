"""Files with one vector field a mode, for ParaView and other readers of VTK files."""

import os
from collections.abc import Callable
from typing import Any, BinaryIO

from numpy.typing import NDArray

from fenics_defo.runtime import Modes, atomic_path
from fenics_defo.runtime.recording import VTK_CELL_TYPES
from fenics_defo.view.captions import field_names
from fenics_defo.view.paths import check_vtk_path
from fenics_defo.view.vtk_legacy import write_legacy
from fenics_defo.view.vtk_xml import write_xml

_WRITERS: dict[str, Callable[..., None]] = {".vtu": write_xml, ".vtk": write_legacy}


def write_modes_vtk(modes: Modes, path: str | os.PathLike[str]) -> None:
    """Write the mesh and every mode to a file that ParaView opens; needs NumPy only.

    Point data: the mode shapes as they are [kg^-1/2], named ``mode_01_440.2Hz`` (rigid ones
    ``mode_01_rigid``), ready for the filter *Warp By Vector*; and ``node_number``, the number of
    each node in the user's file (0 for appended nodes). Field data: ``frequencies_hz``.

    Args:
        modes: what to write; nodes and cells keep their order.
        path: file ending in ``.vtu`` (XML, compressed) or ``.vtk`` (legacy, binary).

    Raises:
        DefoError: the suffix is another one, or the file cannot be written.
    """
    writer = _WRITERS[check_vtk_path(path)]
    point_data: dict[str, NDArray[Any]] = dict(zip(field_names(modes), modes.shapes, strict=True))
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        stream: BinaryIO = file
        writer(
            stream,
            points=modes.points,
            cells=modes.cells,
            vtk_cell_type=VTK_CELL_TYPES[modes.cell_type],
            point_data=point_data | {"node_number": modes.node_numbers},
            field_data={"frequencies_hz": modes.frequencies},
        )
