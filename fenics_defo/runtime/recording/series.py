"""A recorded time series, read back; only what this package wrote, of which nothing is believed."""

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.recording.vtk_frame import read_frame

Array = NDArray[np.float64]

_FRAME = re.compile(
    r'<DataSet timestep="(?P<time>[-+.e0-9]{1,32})" part="0" '
    r'file="(?P<file>(?!\.)[^"/\\&]{1,200}/frame_\d{6,12}\.vtu)"/>'
)
_HEAD = '<?xml version="1.0"?>\n<VTKFile type="Collection"'


@dataclass(frozen=True, slots=True)
class RecordedSeries:
    """A time series in a folder; each frame is read when it is asked for.

    Args:
        path: of its index.
        times: of its frames (k,) [s].
        files: of its frames, k of them.
    """

    path: Path
    times: Array
    files: tuple[Path, ...]

    @property
    def size(self) -> int:
        """Number k of frames."""
        return len(self.files)

    @property
    def points(self) -> Array:
        """Nodes at rest (n, 3) [m], of the first frame.

        Raises:
            FileFormatError: it is missing or damaged.
        """
        return read_frame(self.files[0])["Points"]

    def frame(self, number: int) -> Mapping[str, NDArray[Any]]:
        """The arrays of a frame by name: those at the nodes, and "Points", the nodes at rest.

        Raises:
            FileFormatError: the frame is missing or damaged, or without "displacement".
        """
        arrays = read_frame(self.files[number])
        if arrays.get("displacement", np.empty(0)).shape != arrays["Points"].shape:
            raise FileFormatError(
                f"{self.files[number]}: holds no displacement of its nodes; record it again."
            )
        return arrays


def read_series(path: str | os.PathLike[str], name: str = "motion") -> RecordedSeries:
    """Open a series that `FrameSeries` wrote.

    Args:
        path: its index, ``<name>.pvd``, or the folder of that.
        name: of the series in a folder.

    Returns:
        the series, with one frame at least.

    Raises:
        FileFormatError: there is none, or its index is damaged or holds no frame.
    """
    index = Path(path)
    if index.is_dir():
        index = index / f"{name}.pvd"
    try:
        text = index.read_text("utf-8")
    except OSError as error:
        raise FileFormatError(
            f"{index}: cannot be read ({error.strerror or error}); name the folder of a run of "
            "fenics-defo simulate that wrote its series."
        ) from error
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{index}: is damaged ({error}); record the motion again.") from error
    found = list(_FRAME.finditer(text))
    times = [float(match["time"]) for match in found if _is_number(match["time"])]
    if not text.startswith(_HEAD) or len(times) != text.count("<DataSet"):
        raise FileFormatError(f"{index}: is no index of a series that fenics_defo wrote.")
    if not found:
        raise FileFormatError(f"{index}: holds no frame; record the motion again.")
    files = tuple(index.parent / match["file"] for match in found)
    return RecordedSeries(index, np.array(times), files)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
