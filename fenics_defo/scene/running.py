"""A scene simulated into a folder: every step, every row, every frame, and what if it stops."""

import contextlib
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fenics_defo.analysis import Simulation, State, StepReport
from fenics_defo.errors import DefoError, SceneError
from fenics_defo.fem import Solid
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.runtime.recording import FrameMesh
from fenics_defo.scene.building import build_simulation, build_solid
from fenics_defo.scene.cadence import Cadence, is_frame
from fenics_defo.scene.checkpoint import Checkpoint, Tally, scene_identity
from fenics_defo.scene.folder import ResultFolder, make_folder, refuse_to_replace, resumed
from fenics_defo.scene.reading import read_scene
from fenics_defo.scene.records import Scene
from fenics_defo.scene.summary import Standing, summary_record
from fenics_defo.scene.watching import Watcher


def simulate(
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    restart: bool = False,
    overwrite: bool = False,
    checkpoints: Cadence | None = None,
    watcher: Watcher | None = None,
) -> dict[str, Any]:
    """Simulate a scene and write its folder of results.

    The folder gets ``summary.json``, ``probes.csv``, ``energy.csv``, the series ``motion.pvd`` and
    ``checkpoint.npz``. Rows are written whole, one by one; frames, checkpoint and summary appear
    at once: a run that is killed, or that finds the disk full, leaves a valid folder, and what had
    been written then stays. Collective on all ranks; rank 0 alone writes.

    Args:
        scene: scene, or the name of its file.
        output: folder of the results; made if it is missing.
        restart: go on from the checkpoint in the folder. With the direct solver, on as many ranks,
            the tables are those of a run that was never interrupted, bit by bit.
        overwrite: replace an unfinished run of the same scene.
        checkpoints: how often the state is saved; each minute if not given.
        watcher: who looks on.

    Returns:
        the content of ``summary.json``; its ``status`` is "finished", or "interrupted" if the
        watcher stopped the run.

    Raises:
        SceneError: the scene file is at fault.
        MeshError, MaterialError, SelectionError, LoadError: what it asks for does not fit its mesh.
        DivergenceError: a step failed; the folder holds all until then.
        DefoError: the folder cannot be written, or holds an unfinished run.
        FileFormatError: the checkpoint is missing, damaged or one of another scene.
    """
    if restart and overwrite:
        raise SceneError("restart and overwrite exclude each other; give one of them")
    watcher, folder = watcher or Watcher(), Path(output)
    phases = watcher.phases
    with phases("read"):
        if not isinstance(scene, Scene):
            scene = read_scene(scene)
    with phases("build"):
        solid = build_solid(scene)
        found = on_first_rank(
            solid.comm, lambda: _opened(folder, scene_identity(scene, solid), restart, overwrite)
        )
    with phases("start"):
        simulation = build_simulation(scene, solid, start=found is None)
    with contextlib.closing(simulation):
        return _Run(scene, solid, simulation, folder, checkpoints or Cadence(), watcher).go(found)


def _opened(
    folder: Path, identity: dict[str, str], restart: bool, overwrite: bool
) -> Checkpoint | None:
    make_folder(folder)
    if restart:
        return resumed(folder, identity)
    if not overwrite:
        refuse_to_replace(folder, identity)
    return None


class _Run:
    """A simulation under way, and its folder."""

    def __init__(
        self,
        scene: Scene,
        solid: Solid,
        simulation: Simulation,
        folder: Path,
        cadence: Cadence,
        watcher: Watcher,
    ) -> None:
        self._scene, self._solid, self._simulation = scene, solid, simulation
        self._folder, self._cadence, self._watcher = folder, cadence, watcher
        self._names = [probe.name for probe in scene.probes]
        self._identity = scene_identity(scene, solid)
        self._files: ResultFolder | None = None  # rank 0 has it
        self._tally = Tally(
            newton_iterations=0, linear_iterations=0, halvings=0, peaks=(0.0,) * len(self._names)
        )
        self._saved = time.monotonic()
        self._begun_at = 0
        self._is_recorded = False  # whether the tables and the series are up to the state

    def go(self, found: Checkpoint | None) -> dict[str, Any]:
        """Do all the steps that are left."""
        phases, simulation = self._watcher.phases, self._simulation
        if found is not None:
            simulation.restore(found.state, found.energies)
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
        simulation, total = self._simulation, self._scene.time.steps
        self._watcher.moved(simulation.steps, total, simulation.time)
        while simulation.steps < total:
            if self._any(self._watcher.stop()):
                return "interrupted"
            self._count(simulation.advance())
            step, self._is_recorded = simulation.steps, False
            if step == total or step % self._scene.output.rows == 0:
                self._write_row()
            if step == total or is_frame(step, self._scene.time, self._scene.output):
                self._write_frame()
            self._is_recorded = True
            if step < total and self._any(self._is_due(step)):
                self._save()
                self._summarise("running")
            self._watcher.moved(step, total, simulation.time)
        simulation.check_energy()
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
        nodes = self._solid.nodes
        mesh = FrameMesh(nodes.points, nodes.cells, nodes.cell_type)
        self._files = ResultFolder(
            self._folder,
            self._names,
            mesh if self._scene.output.vtk else None,
            resume=found,
        )

    def _count(self, report: StepReport) -> None:
        self._tally = replace(
            self._tally,
            newton_iterations=self._tally.newton_iterations + report.newton_iterations,
            linear_iterations=self._tally.linear_iterations + report.linear_iterations,
            halvings=self._tally.halvings + report.halvings,
        )

    def _write_row(self) -> None:
        simulation = self._simulation
        probes, energies = [simulation.probe(name) for name in self._names], simulation.energies
        lengths = [float(np.linalg.norm(probe)) for probe in probes]
        peaks = tuple(map(max, self._tally.peaks, lengths))
        self._tally = replace(self._tally, peaks=peaks)
        self._on_first(lambda: self._open_files.write_row(simulation.time, probes, energies))

    def _write_frame(self) -> None:
        if not self._scene.output.vtk:
            return
        state = self._simulation.state
        fields = {"displacement": state.displacement, "velocity": state.velocity}
        self._on_first(lambda: self._open_files.write_frame(state.time, fields))

    def _save(self) -> None:
        state, energies = self._simulation.state, self._simulation.energies
        _check_finite(state)
        self._on_first(
            lambda: self._open_files.write_checkpoint(
                Checkpoint(
                    state=state,
                    energies=energies,
                    sizes=self._open_files.sizes,
                    frame_times=self._open_files.frame_times,
                    tally=self._tally,
                    identity=self._identity,
                )
            )
        )
        self._saved = time.monotonic()

    def _summarise(self, status: str, error: str | None = None) -> dict[str, Any]:
        simulation = self._simulation
        probes, energies = [simulation.probe(name) for name in self._names], simulation.energies
        critical_step = simulation.critical_step  # collective, as those before and after
        energy_error, energy_gain = simulation.energy_error, simulation.energy_gain

        def write() -> dict[str, Any]:
            standing = Standing(
                status=status,
                error=error,
                time=simulation.time,
                steps=simulation.steps,
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
            record = summary_record(self._scene, self._solid, standing)
            self._open_files.write_summary(record)
            return record

        return self._on_first(write)

    @property
    def _open_files(self) -> ResultFolder:
        assert self._files is not None  # rank 0 opened it
        return self._files

    def _is_due(self, step: int) -> bool:
        cadence = self._cadence
        if cadence.steps is not None and step % cadence.steps == 0:
            return True
        late = time.monotonic() - self._saved
        return cadence.seconds is not None and self._is_first and late >= cadence.seconds

    @property
    def _is_first(self) -> bool:
        return bool(self._solid.comm.rank == 0)

    def _any(self, here: bool) -> bool:
        """Whether it is so on any rank: all ranks must go the same way."""
        return any(self._solid.comm.allgather(here)) if self._solid.comm.size > 1 else here

    def _on_first[T](self, work: Callable[[], T]) -> T:
        return on_first_rank(self._solid.comm, lambda: _with_our_errors(work))


def _check_finite(state: State) -> None:
    for name in ("displacement", "velocity", "acceleration"):
        if not np.isfinite(getattr(state, name)).all():
            raise DefoError(
                f"the {name} holds NaN or infinity at {state.time:.6g} s, which was not saved; "
                "the computation has diverged, try a smaller step."
            )


def _with_our_errors[T](work: Callable[[], T]) -> T:
    try:
        return work()
    except OSError as error:
        if isinstance(error, DefoError):
            raise
        named = "" if error.filename is None else f"{error.filename}: "
        raise DefoError(f"{named}{error.strerror or error}") from error
