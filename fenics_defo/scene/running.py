"""A scene simulated into a folder, all of its body."""

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fenics_defo.errors import SceneError
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.scene.body import full_body
from fenics_defo.scene.building import build_simulation, build_solid
from fenics_defo.scene.cadence import Cadence
from fenics_defo.scene.checkpoint import Checkpoint, scene_identity
from fenics_defo.scene.folder import make_folder, refuse_to_replace, resumed
from fenics_defo.scene.reading import read_scene
from fenics_defo.scene.records import Scene
from fenics_defo.scene.run import Run, Saving
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
        identity = scene_identity(scene, solid)
        found = on_first_rank(solid.comm, lambda: _opened(folder, identity, restart, overwrite))
    with phases("start"):
        simulation = build_simulation(scene, solid, start=found is None)
    with contextlib.closing(simulation):
        if found is not None:
            simulation.restore(found.state, found.energies)
        return Run(
            scene,
            full_body(solid, scene.solver.linear),
            simulation,
            folder=folder,
            watcher=watcher,
            together=_Ranks(solid.comm),
            saving=Saving(cadence=checkpoints or Cadence(), identity=identity),
        ).go(found)


def _opened(
    folder: Path, identity: dict[str, str], restart: bool, overwrite: bool
) -> Checkpoint | None:
    make_folder(folder)
    if restart:
        return resumed(folder, identity)
    if not overwrite:
        refuse_to_replace(folder, identity)
    return None


class _Ranks:
    """The processes of MPI.

    Args:
        comm: communicator.
    """

    def __init__(self, comm: Any) -> None:
        self._comm = comm

    @property
    def is_first(self) -> bool:
        """Whether this is rank 0."""
        return bool(self._comm.rank == 0)

    def on_first[T](self, work: Callable[[], T]) -> T:
        """Do something on rank 0 and give its result, or its error, to all ranks."""
        return on_first_rank(self._comm, work)

    def any(self, here: bool) -> bool:
        """Whether it is so on any rank."""
        return any(self._comm.allgather(here)) if self._comm.size > 1 else here
