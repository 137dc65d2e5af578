"""Scenes: what a TOML file says, its simulation, and small models of its body.

The names load on first use: reading a scene needs neither DOLFINx nor PETSc, playing one NumPy
only.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.scene.building import (
        build_initial,
        build_integrator,
        build_loads,
        build_prescribed,
        build_simulation,
        build_solid,
    )
    from fenics_defo.scene.cadence import Cadence
    from fenics_defo.scene.checkpoint import Checkpoint, load_checkpoint
    from fenics_defo.scene.parsing import parse_scene
    from fenics_defo.scene.playing import play
    from fenics_defo.scene.reading import read_scene
    from fenics_defo.scene.recipe import Recipe
    from fenics_defo.scene.records import Scene
    from fenics_defo.scene.reducing import reduce_scene
    from fenics_defo.scene.running import simulate
    from fenics_defo.scene.watching import Watcher

_HOME = {
    "Cadence": "cadence",
    "Checkpoint": "checkpoint",
    "Recipe": "recipe",
    "Scene": "records",
    "Watcher": "watching",
    "build_initial": "building",
    "build_integrator": "building",
    "build_loads": "building",
    "build_prescribed": "building",
    "build_simulation": "building",
    "build_solid": "building",
    "load_checkpoint": "checkpoint",
    "parse_scene": "parsing",
    "play": "playing",
    "read_scene": "reading",
    "reduce_scene": "reducing",
    "simulate": "running",
}

__all__ = [
    "Cadence",
    "Checkpoint",
    "Recipe",
    "Scene",
    "Watcher",
    "build_initial",
    "build_integrator",
    "build_loads",
    "build_prescribed",
    "build_simulation",
    "build_solid",
    "load_checkpoint",
    "parse_scene",
    "play",
    "read_scene",
    "reduce_scene",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
