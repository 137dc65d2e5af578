"""Results written while a computation runs, so that what has been written once is never lost."""

from fenics_defo.runtime.recording.csv_table import CsvTable
from fenics_defo.runtime.recording.frames import FrameSeries
from fenics_defo.runtime.recording.series import RecordedSeries, read_series
from fenics_defo.runtime.recording.vtk_frame import VTK_CELL_TYPES, FrameMesh, read_frame

__all__ = [
    "VTK_CELL_TYPES",
    "CsvTable",
    "FrameMesh",
    "FrameSeries",
    "RecordedSeries",
    "read_frame",
    "read_series",
]
