"""What a model of a scene's body carries for scenes: by which name, and for which body.

A model holds the projection of each load that its scene has, by a name that says what acts and
where, for a unit of it along each axis: another scene of the same body may change directions,
amounts and histories, but not the places.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fenics_defo.errors import SceneError
from fenics_defo.scene.records import LoadTable, Scene
from fenics_defo.scene.table import AXES

#: Names of the momenta Uᵀ M e of unit fields e: a translation along each axis, and a displacement
#: along the first axis that grows with the distance from the centre of mass along the second.
TRANSLATIONS = tuple(f"mass times translation {i}" for i in AXES)
STRETCHES = tuple(f"mass times {i} along {j}" for i in AXES for j in AXES)


def mode_name(number: int) -> str:
    """Name of the momentum Uᵀ M φ of a mode whose largest displacement is 1 m."""
    return f"mass times mode {number}"


def load_names(scene: Scene, number: int) -> tuple[str, ...]:
    """Names of the projections that a load needs: one an axis, one alone for a pressure.

    Args:
        scene: scene.
        number: index of the load, from 0; gravity needs none, each model carries it.
    """
    load = scene.loads[number]
    if load.kind == "gravity":
        return ()
    place = _place(scene, number)
    if load.kind == "pressure":
        return (f"pressure on {place}",)
    # A momentum at a point or node goes to the same nodes as a force there.
    kind = "force" if load.kind == "point" or load.region is None else load.kind
    what = {"force": "force at", "traction": "traction on", "impulse": "momentum of"}[kind]
    return tuple(f"{what} {place} along {axis}" for axis in AXES)


def body_identity(scene: Scene) -> dict[str, str]:
    """What must be the same for a model of one scene's body to stand for another's.

    The mesh is known by the bytes of its file and by what is made of them.

    Returns:
        a text each for the tables mesh, material and fixed, and the mesh file's digest, which is
        empty where the file is not there.
    """
    tables = dict(scene.tables)
    mesh = {key: value for key, value in tables.get("mesh", {}).items() if key != "file"}
    return {
        "mesh": _text({"order": 1, **mesh}),
        "material": _text(tables.get("material", [])),
        "fixed": _text(tables.get("fixed", [])),
        "digest": _digest(scene.mesh.file),
    }


def check_same_body(scene: Scene, model: str, carried: Mapping[str, str]) -> bool:
    """Refuse a scene of another body than the model's.

    Args:
        scene: scene.
        model: name of the model's file.
        carried: `body_identity` of the scene that the model was made of.

    Returns:
        whether the mesh file was there to be compared.

    Raises:
        SceneError: it is another body.
    """
    now = body_identity(scene)
    for name, brackets in (
        ("material", "[[material]]"),
        ("fixed", "[[fixed]]"),
        ("mesh", "[mesh]"),
    ):
        if now[name] != carried.get(name):
            raise SceneError(
                f"{scene.path}: {brackets} differs from that of the scene that {model} was reduced "
                "from; restore it, or reduce this scene"
            )
    if now["digest"] and now["digest"] != carried.get("digest"):
        raise SceneError(
            f"{scene.path}: [mesh]: {scene.mesh.file} is not the mesh that {model} was reduced "
            "from; name that mesh, or reduce this scene"
        )
    return bool(now["digest"])


def _place(scene: Scene, number: int) -> str:
    """Where a load acts, as the scene file says it."""
    load: LoadTable = scene.loads[number]
    if load.point is not None:
        return "(" + ", ".join(repr(c) for c in load.point) + ") m"
    if load.node is not None:
        return f"node {load.node}"
    # As it is written: a file of nodes has been given the path of the scene's folder since.
    return repr(scene.tables["load"][number]["region"])


def _text(value: Any) -> str:
    """A table as text, whole numbers as the floats that they stand for."""
    return json.dumps(_floats(value), sort_keys=True, default=str)


def _floats(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _floats(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_floats(item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return float(value) if abs(value) < 2**53 else value
    return value


def _digest(file: Path) -> str:
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return ""
