"""A scene played by a model into a folder, with NumPy alone."""

import logging
import os
from pathlib import Path
from typing import Any

from fenics_defo.errors import DefoError, FileFormatError, SceneError
from fenics_defo.runtime import ReducedModel, load
from fenics_defo.scene.body import Body
from fenics_defo.scene.carried import check_same_body
from fenics_defo.scene.folder import CHECKPOINT, make_folder
from fenics_defo.scene.parsing import parse_scene
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_flight import ReducedFlight
from fenics_defo.scene.reduced_motion import ReducedMotion
from fenics_defo.scene.run import Run
from fenics_defo.scene.schema import EXPLICIT
from fenics_defo.scene.together import Alone
from fenics_defo.scene.watching import Watcher

_log = logging.getLogger(__name__)


def play(
    model: str | os.PathLike[str],
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    watcher: Watcher | None = None,
) -> dict[str, Any]:
    """Move a scene's body by a model of it and write the folder that `simulate` writes.

    All but ``checkpoint.npz``, and the series for ParaView only if the model stores all nodes.
    Needs NumPy only; one process.

    Args:
        model: name of the model's file.
        scene: scene, or the name of its file; its materials need not have been read.
        output: folder of the results; made if it is missing.
        overwrite: replace what `simulate` has left there.
        watcher: who looks on.

    Returns:
        the content of ``summary.json``; its ``status`` is "finished", or "interrupted" if the
        watcher stopped the run.

    Raises:
        FileFormatError: the model's file is missing, damaged or no model.
        SceneError: the scene file is at fault, is of another body than the model, or asks for a
            load, a probe or a start that the model does not carry.
        DivergenceError: a step failed; the folder holds all until then.
        DefoError: the folder cannot be written, or holds the results of `simulate`.
    """
    watcher, folder, file = watcher or Watcher(), Path(output), Path(model)
    with watcher.phases("read"):
        if not isinstance(scene, Scene):
            scene = parse_scene(scene)
        reduced = load(file)
    with watcher.phases("start"):
        _check_scene(reduced, file, scene)
        move = ReducedMotion if reduced.frame is None else ReducedFlight
        motion = move(reduced, file, scene, watcher.phases)
        body = _body(reduced, file)
        make_folder(folder)
        if not overwrite:
            _refuse_to_replace(folder)
    return Run(
        scene,
        body,
        motion,
        folder=folder,
        watcher=watcher,
        together=Alone(),
    ).go(None)


def _check_scene(model: ReducedModel, file: Path, scene: Scene) -> None:
    """Refuse a scene that the model cannot play, and say what it leaves out."""
    carried = model.provenance.get("scene")
    if not isinstance(carried, dict):
        raise SceneError(
            f"{file}: was not reduced from a scene, so nothing tells whether {scene.path} is of "
            "its body; step it in Python, or make it by fenics-defo reduce"
        )
    if not check_same_body(scene, str(file), carried):
        _log.warning("%s is not there: nothing tells whether it is the model's", scene.mesh.file)
    for probe in scene.probes:
        known = model.probes.get(probe.name)
        if known is None or tuple(known.point.tolist()) != probe.point:
            places = [f"{name} at {tuple(p.point.tolist())} m" for name, p in model.probes.items()]
            raise SceneError(
                f"{scene.path}: [[probe]] {probe.name}: {file} carries no such probe at "
                f"{probe.point} m, only {', '.join(places) or 'none'}; reduce a scene that has it, "
                "or leave it out"
            )
    if any(item.displacement is not None for item in scene.fixed):
        raise SceneError(
            f"{scene.path}: [[fixed]]: nodes that are moved as told cannot be played by a model; "
            "simulate the scene, or leave displacement out"
        )
    mass = "lumped" if scene.time.integrator in EXPLICIT else "consistent"
    if model.provenance.get("mass", mass) != mass and not scene.time.is_static:
        _log.warning(
            "the model's mass is %s; simulate takes the %s one for %s, so results differ a little",
            model.provenance["mass"],
            mass,
            scene.time.integrator,
        )
    if any(item.kind == "pressure" for item in scene.loads):
        _log.warning("pressures act as at rest: in a model they do not follow the surface")


def _body(model: ReducedModel, file: Path) -> Body:
    """What the results tell about the body."""
    origin = model.provenance["scene"]
    try:
        notes = tuple(str(note) for note in origin["notes"])
        order, nodes = int(origin["order"]), int(origin["nodes"])
    except (LookupError, TypeError, ValueError) as error:
        raise FileFormatError(
            f"{file}: does not tell of which body it is a model ({error!r}); reduce again"
        ) from error
    outputs = model.outputs
    is_whole = len(model.nodes) == nodes and outputs.cells is not None
    return Body(
        points=model.points,
        cells=outputs.cells if is_whole else outputs.cells[:0],
        cell_type=outputs.cell_type,
        order=order,
        dofs=model.size,
        solver="dense",
        notes=notes,
        more={"model": str(file), "force": model.law.kind},
    )


def _refuse_to_replace(folder: Path) -> None:
    """Keep the results of `simulate`, which may have taken long, from being lost.

    Raises:
        DefoError: the folder holds some.
    """
    if (folder / CHECKPOINT).exists():  # `play` leaves none
        raise DefoError(
            f"{folder}: holds the results of simulate; name another folder, to compare with them, "
            "or add --overwrite."
        )
