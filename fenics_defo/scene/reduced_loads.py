"""A scene's loads and initial state in the coordinates of a model; NumPy only."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.histories import History
from fenics_defo.errors import SceneError
from fenics_defo.runtime import ReducedModel
from fenics_defo.scene.carried import STRETCHES, TRANSLATIONS, load_names, mode_name
from fenics_defo.scene.load_factors import load_factor
from fenics_defo.scene.records import InitialTable, LoadTable, Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Dead:
    """A load that does not depend on the displacement.

    Args:
        history: its factor.
        force: reduced (r,).
    """

    history: History
    force: Array


class ReducedLoads:
    """The loads of a scene upon a model.

    Args:
        model: model.
        file: its name, for messages.
        scene: scene.

    Raises:
        SceneError: the model does not carry one of them.
    """

    def __init__(self, model: ReducedModel, file: Path, scene: Scene) -> None:
        self._dead: list[_Dead] = []
        #: Times [s] and reduced momenta (r,) of the impulses.
        self.impulses: list[tuple[float, Array]] = []
        self._size = model.size
        for number, load in enumerate(scene.loads):
            force = _projection(model, file, scene, number)
            if load.kind == "impulse":
                self.impulses.append((load.time, force))
            else:
                self._dead.append(_Dead(load_factor(load.history, scene.time), force))

    def force(self, time: float) -> Array:
        """Reduced force (r,) at a time [s]."""
        total = np.zeros(self._size)
        for dead in self._dead:
            amount = dead.history(time)
            if amount != 0.0:
                total += amount * dead.force
        return total


def initial_coordinates(model: ReducedModel, file: Path, scene: Scene) -> tuple[Array, Array]:
    """Reduced displacement and velocity (r,) at time zero: the nearest by mass to the scene's.

    Raises:
        SceneError: the model does not carry what the scene starts from.
    """
    given = scene.initial
    rows: dict[str, Array] = {}
    states = []
    for weights in (_displacement(given), _velocity(given)):
        momentum = np.zeros(model.size)
        for name, weight in weights.items():
            if weight != 0.0:
                rows[name] = rows[name] if name in rows else _carried(model, file, scene, name)
                momentum += weight * rows[name]
        states.append(np.linalg.solve(model.mass, momentum) if momentum.any() else momentum)
    return states[0], states[1]


def _displacement(given: InitialTable) -> dict[str, float]:
    """Weights of the unit fields."""
    weights = dict(zip(TRANSLATIONS, given.displacement, strict=True))
    gradient = np.diag(np.asarray(given.stretch) - 1.0)
    weights |= dict(zip(STRETCHES, gradient.ravel().tolist(), strict=True))
    if given.mode is not None:
        weights[mode_name(given.mode)] = given.amplitude
    return weights


def _velocity(given: InitialTable) -> dict[str, float]:
    x, y, z = given.spin
    gradient = (0.0, -z, y, z, 0.0, -x, -y, x, 0.0)  # of spin times arm
    weights = dict(zip(TRANSLATIONS, given.velocity, strict=True))
    return weights | dict(zip(STRETCHES, gradient, strict=True))


def _projection(model: ReducedModel, file: Path, scene: Scene, number: int) -> Array:
    """The force or momentum (r,) of a load whose factor is one."""
    load: LoadTable = scene.loads[number]
    if load.kind == "gravity":
        return np.asarray(model.gravity(load.vector))
    amounts = (load.value,) if load.kind == "pressure" else load.vector
    total = np.zeros(model.size)
    for name, amount in zip(load_names(scene, number), amounts, strict=True):
        if name not in model.loads:
            raise SceneError(
                f"{scene.path}: [[load]] {number + 1}: {file} carries no {_without_axis(name)}, "
                f"only {_known(model)}; reduce a scene that has this load, or leave it out"
            )
        total += amount * model.load(name)
    return total


def _carried(model: ReducedModel, file: Path, scene: Scene, name: str) -> Array:
    if name not in model.loads:
        raise SceneError(
            f"{scene.path}: [initial]: {file} carries no {name!r}; reduce a scene that starts so, "
            "or leave it out"
        )
    return np.asarray(model.load(name))


def _known(model: ReducedModel) -> str:
    """What a model carries, as part of a sentence."""
    names = [_without_axis(name) for name in model.loads if not name.startswith("mass times")]
    return "".join(f"{name}, " for name in dict.fromkeys(names)) + "gravity"


def _without_axis(name: str) -> str:
    return name.partition(" along ")[0]
