"""Results written while a computation runs, so that what has been written once is never lost."""

from fenics_defo.runtime.recording.csv_table import CsvTable
from fenics_defo.runtime.recording.frames import FrameSeries
from fenics_defo.runtime.recording.vtk_frame import VTK_CELL_TYPES, FrameMesh

__all__ = ["VTK_CELL_TYPES", "CsvTable", "FrameMesh", "FrameSeries"]
