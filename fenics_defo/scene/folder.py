"""The folder that a run fills: tables, series, checkpoint, summary; one rank alone has it open."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Energies
from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.runtime import atomic_path
from fenics_defo.runtime.recording import CsvTable, FrameMesh, FrameSeries
from fenics_defo.scene.checkpoint import Checkpoint, changed_tables, load_checkpoint

SUMMARY, CHECKPOINT = "summary.json", "checkpoint.npz"
PROBES, ENERGY, SERIES = "probes.csv", "energy.csv", "motion"

_ENERGY_COLUMNS = ("time", "kinetic", "strain", "external", "dissipated")
_GOES_ON = ("running", "interrupted")


class ResultFolder:
    """Files of one run. What it has written stays readable, however the run ends.

    Args:
        folder: made if it is missing.
        probes: names of the probes.
        mesh: for the series; None to write none.
        resume: checkpoint from which the run goes on; what was written later is cut off.
        checkpoints: whether there will be any.

    Raises:
        DefoError: the folder cannot be written.
        FileFormatError: the files there are not those of the checkpoint.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        probes: Sequence[str],
        mesh: FrameMesh | None,
        *,
        resume: Checkpoint | None = None,
        checkpoints: bool = True,
    ) -> None:
        self.path = Path(folder)
        self._checkpoints = [CHECKPOINT] if checkpoints else []
        make_folder(self.path)
        if resume is None:  # before the results go that they speak of
            (self.path / SUMMARY).unlink(missing_ok=True)
            (self.path / CHECKPOINT).unlink(missing_ok=True)
            if mesh is None:
                FrameSeries.remove(self.path, SERIES)
        columns = ["time", *(f"{name}_{axis}" for name in probes for axis in "xyz")]
        sizes: tuple[int | None, int | None] = (None, None) if resume is None else resume.sizes
        self._probes = CsvTable(self.path / PROBES, columns, size=sizes[0])
        self._energy = CsvTable(self.path / ENERGY, _ENERGY_COLUMNS, size=sizes[1])
        times = () if resume is None else resume.frame_times
        self._series = None if mesh is None else FrameSeries(self.path, SERIES, mesh, times=times)

    @property
    def sizes(self) -> tuple[int, int]:
        """Lengths of the tables of probes and of energies [bytes]."""
        return self._probes.size, self._energy.size

    @property
    def frame_times(self) -> tuple[float, ...]:
        """Times of the frames [s]."""
        return () if self._series is None else self._series.times

    @property
    def files(self) -> list[str]:
        """Names of the files, the index in place of its frames."""
        series = [] if self._series is None else [f"{SERIES}.pvd"]
        return [SUMMARY, PROBES, ENERGY, *series, *self._checkpoints]

    def write_row(
        self, time: float, probes: Sequence[NDArray[np.float64]], energies: Energies
    ) -> None:
        """Append to both tables.

        Args:
            time: [s].
            probes: displacement (3,) of each probe [m].
            energies: [J].
        """
        self._probes.append([time, *(float(value) for probe in probes for value in probe)])
        self._energy.append(
            [time, energies.kinetic, energies.strain, energies.external, energies.dissipated]
        )

    def write_frame(self, time: float, fields: Mapping[str, NDArray[np.float64]]) -> None:
        """Append a frame to the series, if there is one."""
        if self._series is not None:
            self._series.append(time, fields)

    def write_checkpoint(self, checkpoint: Checkpoint) -> None:
        """Replace the checkpoint, once all that it counts on is on the disk."""
        self._probes.sync()
        self._energy.sync()
        checkpoint.save(self.path / CHECKPOINT)

    def write_summary(self, record: Mapping[str, Any]) -> None:
        """Replace the summary."""
        with atomic_path(self.path / SUMMARY) as path:
            path.write_text(json.dumps(record, indent=2, allow_nan=False) + "\n", "utf-8")

    def close(self) -> None:
        """Close the tables."""
        self._probes.close()
        self._energy.close()


def make_folder(path: Path) -> None:
    """Make sure that there is a folder that can be written.

    Raises:
        DefoError: there cannot be one.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DefoError(
            f"{path}: cannot be made a folder for the results ({error.strerror}); "
            "name one that can be written."
        ) from error


def resumed(folder: Path, identity: Mapping[str, str]) -> Checkpoint:
    """The checkpoint in a folder, if it is one of the scene.

    Raises:
        FileFormatError: there is none, it is damaged, or one of another scene.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        raise FileFormatError(
            f"{folder}: holds no {CHECKPOINT} to go on from; run without --restart."
        )
    checkpoint = load_checkpoint(path)
    changed = changed_tables(checkpoint.identity, identity)
    if changed:
        raise FileFormatError(
            f"{path}: belongs to another scene, the tables {', '.join(changed)} differ; restore "
            "them, or run without --restart into another folder."
        )
    return checkpoint


def refuse_to_replace(folder: Path, identity: Mapping[str, str]) -> None:
    """Keep an unfinished run of the same scene from being lost by a forgotten --restart.

    Raises:
        DefoError: the folder holds one.
    """
    try:
        status = json.loads((folder / SUMMARY).read_text("utf-8"))["status"]
        checkpoint = load_checkpoint(folder / CHECKPOINT)
    except (OSError, ValueError, LookupError, TypeError):
        return  # nothing there that could be continued
    if status in _GOES_ON and not changed_tables(checkpoint.identity, identity):
        raise DefoError(
            f"{folder}: holds an unfinished run of this scene, up to {checkpoint.state.time:.6g} s;"
            " add --restart to go on with it, or --overwrite to begin anew."
        )
