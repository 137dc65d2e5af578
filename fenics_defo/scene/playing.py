"""A scene played by a model into a folder, with NumPy alone."""

import json
import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fenics_defo.errors import DefoError, SceneError
from fenics_defo.runtime import ReducedModel, load
from fenics_defo.scene.body import Body
from fenics_defo.scene.carried import check_same_body
from fenics_defo.scene.folder import CHECKPOINT, SUMMARY, make_folder
from fenics_defo.scene.parsing import parse_scene
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_motion import build_motion
from fenics_defo.scene.run import Run
from fenics_defo.scene.together import Alone, with_our_errors
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
        motion = build_motion(reduced, file, scene)
        with_our_errors(lambda: make_folder(folder))
        if not overwrite:
            _refuse_to_replace(folder)
    return Run(
        scene,
        _body(reduced, file, scene),
        motion,
        folder=folder,
        watcher=watcher,
        together=Alone(),
    ).go(None)
