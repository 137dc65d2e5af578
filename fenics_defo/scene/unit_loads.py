"""The loads of a scene, each for a unit of it along each axis, ready to be projected."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Load
from fenics_defo.fem import Solid
from fenics_defo.scene.building import build_load, mass_arms, mode_field, unheld
from fenics_defo.scene.carried import STRETCHES, TRANSLATIONS, load_names, mode_name
from fenics_defo.scene.records import Scene

Array = NDArray[np.float64]

_UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def unit_loads(scene: Scene, solid: Solid) -> dict[str, Load]:
    """Loads of one unit, always there, by the names that a model carries them by.

    Args:
        scene: scene.
        solid: its body.

    Returns:
        gravity is not among them: each model carries it.

    Raises:
        SceneError: a node that the mesh does not have.
    """
    loads: dict[str, Load] = {}
    for number, load in enumerate(scene.loads):
        names = load_names(scene, number)
        if load.kind == "pressure":
            units = [replace(load, value=1.0, history=None)]
        else:
            units = [replace(load, vector=unit, history=None, time=0.0) for unit in _UNITS]
        for name, unit in zip(names, units, strict=False):  # gravity has no names
            loads[name] = build_load(scene, number + 1, unit, solid)
    return loads


def initial_fields(scene: Scene, solid: Solid) -> Iterator[tuple[str, Array]]:
    """Unit fields (n, 3) that an initial state is a sum of, by the names of their momenta.

    Args:
        scene: scene.
        solid: its body; collective.
    """
    arms = mass_arms(solid)
    for name, unit in zip(TRANSLATIONS, np.eye(3), strict=True):
        yield name, unheld(unit, solid)
    entries = [(i, j) for i in range(3) for j in range(3)]
    for name, (i, j) in zip(STRETCHES, entries, strict=True):
        field = np.zeros_like(arms)
        field[:, i] = arms[:, j]
        yield name, unheld(field, solid)
    if scene.initial.mode is not None:
        number = scene.initial.mode
        yield mode_name(number), mode_field(scene, solid, number)
