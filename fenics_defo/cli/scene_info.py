"""What a scene file asks for, as a record for JSON and as text."""

import dataclasses
from typing import Any

from fenics_defo.cli.materials import constants_of, law_of
from fenics_defo.cli.number_text import constants_text, short_number
from fenics_defo.scene import Scene, read_scene

_LEFT_OUT = {"tables", "materials", "path", "mesh"}


def scene_record(file: str) -> dict[str, Any]:
    """Read a scene and return what it asks for, ready for JSON; the mesh is not opened.

    Args:
        file: scene file.

    Raises:
        SceneError: the file is at fault.
    """
    scene = read_scene(file)
    fields = {
        field.name: _plain(getattr(scene, field.name))
        for field in dataclasses.fields(scene)
        if field.name not in _LEFT_OUT
    }
    mesh = {**_plain(scene.mesh), "file": str(scene.mesh.file)}
    return {
        "kind": "scene",
        "file": file,
        "mesh": mesh,
        "steps": scene.time.steps,
        "materials": _materials(scene),
        **fields,
    }


def scene_text(record: dict[str, Any]) -> str:
    """Write the record of `scene_record` for people."""
    mesh, time = record["mesh"], record["time"]
    lines = [
        f"file: {record['file']}, a scene",
        f"mesh: {mesh['file']}, displacements of order {mesh['order']}",
        *(_material_line(material) for material in record["materials"]),
        *(f"fixed: {item['region']} along {item['components']}" for item in record["fixed"]),
        *(f"load: {_load_text(load)}" for load in record["loads"]),
        f"time: {time['duration']:.6g} s in {record['steps']} steps of {time['step']:.6g} s, "
        f"{time['integrator']}",
        f"solver: {record['solver']['linear']}",
        *(f"probe: {p['name']} at ({_numbers(p['point'])}) m" for p in record["probes"]),
    ]
    return "\n".join(lines) + "\n"


def _materials(scene: Scene) -> list[dict[str, Any]]:
    return [
        {"region": region, "law": law_of(material), "constants": constants_of(material)}
        for region, material in scene.materials.items()
    ]


def _material_line(material: dict[str, Any]) -> str:
    region = "" if material["region"] is None else f"{material['region']}: "
    return f"material: {region}{constants_text(material['constants'])} ({material['law']})"


def _load_text(load: dict[str, Any]) -> str:
    amount = short_number(load["value"]) if load["kind"] == "pressure" else _numbers(load["vector"])
    place = next((load[k] for k in ("region", "point", "node") if load[k] is not None), None)
    where = "" if place is None else f" at {place}"
    history = "" if load["history"] is None else f", {load['history']['kind']}"
    return f"{load['kind']} ({amount}){where}{history}"


def _numbers(values: Any) -> str:
    return ", ".join(map(short_number, values))


def _plain(value: Any) -> Any:
    """Records as dictionaries, tuples as lists."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {f.name: _plain(getattr(value, f.name)) for f in fields if f.name != "file"}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
