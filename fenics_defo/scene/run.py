"""The steps of a run: every row, every frame, every checkpoint, and what if it stops."""

import contextlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.states import Energies, State, StepReport
from fenics_defo.errors import DefoError
from fenics_defo.scene.body import Body
from fenics_defo.scene.cadence import Cadence, is_frame
from fenics_defo.scene.checkpoint import Checkpoint, Tally
from fenics_defo.scene.folder import ResultFolder
from fenics_defo.scene.records import Scene
from fenics_defo.scene.summary import Standing, summary_record
from fenics_defo.scene.together import Together, with_our_errors
from fenics_defo.scene.watching import Watcher


class Moving(Protocol):
    """A body under way: what the loop asks of it."""

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""

    @property
    def steps(self) -> int:
        """Number of whole steps done since time zero."""

    @property
    def critical_step(self) -> float:
        """Largest stable step [s]; infinite for implicit methods."""

    @property
    def state(self) -> State:
        """The last good state at all nodes that are shown."""

    @property
    def energies(self) -> Energies:
        """Energies of the last good state."""

    @property
    def energy_error(self) -> float | None:
        """Largest error of the energy balance so far over all energy put in [-]; None: statics."""

    @property
    def energy_gain(self) -> float | None:
        """The same of what was gained [-]."""

    def check_energy(self) -> None:
        """Refuse a motion that has run away."""

    def probe(self, name: str) -> NDArray[np.float64]:
        """Displacement (3,) [m] of a probe."""

    def advance(self) -> StepReport:
        """Do one step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Saving:
    """Checkpoints of a run.

    Args:
        cadence: how often they are written.
        identity: of the scene, see `scene_identity`.
    """

    cadence: Cadence
    identity: Mapping[str, str]


class Run:
    """A body under way, and the folder of its results.

    Args:
        scene: scene.
        body: what the results tell about the body.
        motion: the body under way.
        folder: of the results; it exists.
        watcher: who looks on.
        together: the processes of the run.
        saving: of checkpoints; None: none are written.
    """

    def __init__(
        self,
        scene: Scene,
        body: Body,
        motion: Moving,
        *,
        folder: Path,
        watcher: Watcher,
        together: Together,
        saving: Saving | None = None,
    ) -> None:
        self._scene, self._body, self._motion = scene, body, motion
        self._folder, self._watcher, self._together = folder, watcher, together
        self._saving = saving
        self._names = [probe.name for probe in scene.probes]
        self._files: ResultFolder | None = None  # rank 0 has it
        self._tally = Tally(
            newton_iterations=0, linear_iterations=0, halvings=0, peaks=(0.0,) * len(self._names)
        )
        self._saved = time.monotonic()
        self._begun_at = 0
        self._is_recorded = False  # whether the tables and the series are up to the state

    def go(self, found: Checkpoint | None) -> dict[str, Any]:
        """Do all the steps that are left.

        Args:
            found: checkpoint that the body goes on from; None: from the start.

        Returns:
            the content of ``summary.json``.

        Raises:
            DivergenceError: a step failed; the folder holds all until then.
            DefoError: the folder cannot be written.
        """
        phases = self._watcher.phases
        if found is not None:
            self._tally, self._begun_at = found.tally, found.state.step
        self._on_first(lambda: self._open(found))
        try:
            if found is None:
                self._write_row()
                self._write_frame()
            self._is_recorded = True
            if found is None:
                self._save()
            self._summarise("running")
            with phases("simulate"):
                status = self._steps()
            return self._end(status)
        except DefoError as error:
            self._end_early(error)
            raise
        finally:
            if self._files is not None:
                self._files.close()

    def _steps(self) -> str:
        motion, total = self._motion, self._scene.time.steps
        self._watcher.moved(motion.steps, total, motion.time)
        while motion.steps < total:
            if self._together.any(self._watcher.stop()):
                return "interrupted"
            self._count(motion.advance())
            step, self._is_recorded = motion.steps, False
            if step == total or step % self._scene.output.rows == 0:
                self._write_row()
            if step == total or is_frame(step, self._scene.time, self._scene.output):
                self._write_frame()
            self._is_recorded = True
            if step < total and self._together.any(self._is_due(step)):
                self._save()
                self._summarise("running")
            self._watcher.moved(step, total, motion.time)
        motion.check_energy()
        return "finished"

    def _end(self, status: str) -> dict[str, Any]:
        self._save()
        return self._summarise(status)

    def _end_early(self, error: DefoError) -> None:
        """Keep the last good state, if that is possible: the error is what is told.

        Where writing failed the earlier checkpoint stands: rows would be missing after this one.
        """
        with contextlib.suppress(DefoError, OSError):
            if self._is_recorded:
                self._save()
            self._summarise("failed", str(error))

    def _open(self, found: Checkpoint | None) -> None:
        self._files = ResultFolder(
            self._folder,
            self._names,
            self._body.frame_mesh if self._scene.output.vtk else None,
            resume=found,
            checkpoints=self._saving is not None,
        )

    def _count(self, report: StepReport) -> None:
        self._tally = replace(
            self._tally,
            newton_iterations=self._tally.newton_iterations + report.newton_iterations,
            linear_iterations=self._tally.linear_iterations + report.linear_iterations,
            halvings=self._tally.halvings + report.halvings,
        )

    def _write_row(self) -> None:
        motion = self._motion
        probes, energies = [motion.probe(name) for name in self._names], motion.energies
        lengths = [float(np.linalg.norm(probe)) for probe in probes]
        peaks = tuple(map(max, self._tally.peaks, lengths))
        self._tally = replace(self._tally, peaks=peaks)
        self._on_first(lambda: self._open_files.write_row(motion.time, probes, energies))

    def _write_frame(self) -> None:
        if not self._scene.output.vtk or self._body.frame_mesh is None:
            return
        state = self._motion.state
        fields = {"displacement": state.displacement, "velocity": state.velocity}
        self._on_first(lambda: self._open_files.write_frame(state.time, fields))

    def _save(self) -> None:
        saving = self._saving
        if saving is None:
            return
        state, energies = self._motion.state, self._motion.energies
        _check_finite(state)
        self._on_first(
            lambda: self._open_files.write_checkpoint(
                Checkpoint(
                    state=state,
                    energies=energies,
                    sizes=self._open_files.sizes,
                    frame_times=self._open_files.frame_times,
                    tally=self._tally,
                    identity=saving.identity,
                )
            )
        )
        self._saved = time.monotonic()

    def _summarise(self, status: str, error: str | None = None) -> dict[str, Any]:
        motion = self._motion
        probes, energies = [motion.probe(name) for name in self._names], motion.energies
        critical_step = motion.critical_step  # collective, as those before and after
        energy_error, energy_gain = motion.energy_error, motion.energy_gain

        def write() -> dict[str, Any]:
            standing = Standing(
                status=status,
                error=error,
                time=motion.time,
                steps=motion.steps,
                begun_at=self._begun_at,
                probes=probes,
                energies=energies,
                energy_error=energy_error,
                energy_gain=energy_gain,
                critical_step=critical_step,
                tally=self._tally,
                frames=len(self._open_files.frame_times),
                folder=str(self._folder),
                files=self._open_files.files,
                seconds=self._watcher.phases.seconds,
            )
            record = summary_record(self._scene, self._body, standing)
            self._open_files.write_summary(record)
            return record

        return self._on_first(write)

    @property
    def _open_files(self) -> ResultFolder:
        assert self._files is not None  # rank 0 opened it
        return self._files

    def _is_due(self, step: int) -> bool:
        if self._saving is None:
            return False
        cadence = self._saving.cadence
        if cadence.steps is not None and step % cadence.steps == 0:
            return True
        late = time.monotonic() - self._saved
        is_late = cadence.seconds is not None and late >= cadence.seconds
        return is_late and self._together.is_first

    def _on_first[T](self, work: Callable[[], T]) -> T:
        return self._together.on_first(lambda: with_our_errors(work))


def _check_finite(state: State) -> None:
    for name in ("displacement", "velocity", "acceleration"):
        if not np.isfinite(getattr(state, name)).all():
            raise DefoError(
                f"the {name} holds NaN or infinity at {state.time:.6g} s, which was not saved; "
                "the computation has diverged, try a smaller step."
            )
