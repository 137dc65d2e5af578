"""A time series that ParaView opens: one file a frame, and an index of the frames that are whole.

A frame is on the disk, under its name, before the index that names it is replaced, and each of the
two is replaced at once: whenever a run is killed, the index opens and all it names is there.
The index is ParaView's collection format, ``.pvd``.
"""

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError
from fenics_defo.runtime.atomic import atomic_path
from fenics_defo.runtime.recording.vtk_frame import FrameMesh, write_frame


class FrameSeries:
    """A growing time series ``<name>.pvd`` with its frames in a folder ``<name>``.

    Args:
        folder: where the series lies; it exists.
        name: of the series.
        mesh: nodes at rest and cells.
        times: times of the frames of an earlier run that are kept, the first ones.

    Raises:
        DefoError: the folder cannot be written, or a frame that is to be kept is missing.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        name: str,
        mesh: FrameMesh,
        *,
        times: tuple[float, ...] = (),
    ) -> None:
        self._index = Path(folder) / f"{name}.pvd"
        self._frames = Path(folder) / name
        self._mesh = mesh
        self._times = list(times)
        try:
            self._frames.mkdir(exist_ok=True)
        except OSError as error:
            raise DefoError(
                f"{self._frames}: cannot be made a folder ({error.strerror}); choose another."
            ) from error
        for number in range(len(self._times)):
            if not self._frame(number).is_file():
                raise DefoError(
                    f"{self._frame(number)}: is missing, though the checkpoint counts on it; "
                    "run again from the beginning."
                )
        self._write_index()  # before frames go that an earlier index names
        self._remove_after(len(self._times))

    @staticmethod
    def remove(folder: str | os.PathLike[str], name: str) -> None:
        """Remove a series, its index first; nothing else in its folder of frames."""
        (Path(folder) / f"{name}.pvd").unlink(missing_ok=True)
        frames = Path(folder) / name
        for path in frames.glob("frame_*.vtu"):
            path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # it is not there, or holds files of others
            frames.rmdir()

    @property
    def times(self) -> tuple[float, ...]:
        """Times of the frames [s]."""
        return tuple(self._times)

    def append(self, time: float, point_data: Mapping[str, NDArray[np.float64]]) -> None:
        """Write one frame, then the index.

        Args:
            time: of the frame, after that of the last one [s].
            point_data: name -> (n,) or (n, d) values at the nodes.

        Raises:
            DefoError: values are not finite, or the disk is full; the series is as it was before.
        """
        for name, values in point_data.items():
            if not np.isfinite(values).all():
                raise DefoError(
                    f"{self._index}: {name} holds NaN or infinity at time {time!r}; no frame was "
                    "written. The computation has diverged, try a smaller step."
                )
        with atomic_path(self._frame(len(self._times))) as path, path.open("wb") as file:
            write_frame(file, self._mesh, time=time, point_data=point_data)
        self._times.append(float(time))
        try:
            self._write_index()
        except BaseException:
            self._times.pop()
            raise

    def _frame(self, number: int) -> Path:
        return self._frames / f"frame_{number:06d}.vtu"

    def _write_index(self) -> None:
        lines = [
            f'<DataSet timestep="{time!r}" part="0" '
            f"file={quoteattr(f'{self._frames.name}/{self._frame(number).name}')}/>"
            for number, time in enumerate(self._times)
        ]
        text = "\n".join(
            [
                '<?xml version="1.0"?>',
                '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">',
                "<Collection>",
                *lines,
                "</Collection>",
                "</VTKFile>\n",
            ]
        )
        with atomic_path(self._index) as path:
            path.write_text(text, encoding="utf-8")

    def _remove_after(self, count: int) -> None:
        """Remove frames of an earlier run that the index does not name."""
        kept = {self._frame(number).name for number in range(count)}
        for path in self._frames.glob("frame_*.vtu"):
            if path.name not in kept:
                path.unlink(missing_ok=True)
