"""What a step takes, on the clock."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.phases import Phases
from fenics_defo.errors import DefoError
from fenics_defo.runtime import ReducedModel
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_flight import ReducedFlight
from fenics_defo.scene.reduced_loads import ReducedLoads, initial_coordinates
from fenics_defo.scene.reduced_motion import ReducedMotion, make_stepper
from fenics_defo.scene.trade.exact_motion import ExactMotion, make_filter
from fenics_defo.scene.trade.records import FILTER, Candidate

Array = NDArray[np.float64]

type Moving = ReducedMotion | ReducedFlight | ExactMotion

BATCH = 64
_ROUNDS, _WARM, _FEWEST, _MOST, _SECONDS = 3, 10, 50, 2000, 0.1


def scene_of(candidate: Candidate, scene: Scene) -> Scene:
    """The scene with a candidate's method and step."""
    integrator = scene.time.integrator if candidate.kind == FILTER else candidate.integrator
    return replace(scene, time=replace(scene.time, integrator=integrator, step=candidate.step))


def motion_of(candidate: Candidate, model: ReducedModel, scene: Scene) -> Moving:
    """A model under way through the scene of a candidate.

    Args:
        candidate: which method.
        model: model.
        scene: as `scene_of` gives it.

    Raises:
        DefoError: as the motion's class.
    """
    file = Path(candidate.name)
    if candidate.kind == FILTER:
        return ExactMotion(model, file, scene, Phases())
    move = ReducedMotion if model.frame is None else ReducedFlight
    return move(model, file, scene, Phases())


def step_seconds(candidate: Candidate, model: ReducedModel, scene: Scene) -> Array:
    """Seconds of single steps of a model through a scene, without loads, tables and energies.

    Of equilibria and of flights with the loads: they are part of the step there.
    """
    if scene.time.is_static or model.frame is not None:
        return _of_motion(lambda: motion_of(candidate, model, scene), scene.time.steps)
    file = Path(candidate.name)
    given = ReducedLoads(model, file, scene)
    loads = [given.force(i * scene.time.step) for i in range(1, min(scene.time.steps, _MOST) + 1)]
    q, v = initial_coordinates(model, file, scene)
    return _quietest(lambda: _of_steps(candidate, model, scene, q, v, given, loads))


def _quietest(timed: Callable[[], Array]) -> Array:
    """The round of the lowest median: other processes can only make a round slower."""
    return min((timed() for _ in range(_ROUNDS)), key=lambda seconds: float(np.median(seconds)))


def _of_steps(
    candidate: Candidate,
    model: ReducedModel,
    scene: Scene,
    q: Array,
    v: Array,
    given: ReducedLoads,
    loads: list[Array],
) -> Array:
    seconds: list[float] = []
    begin = time.perf_counter()
    while not _is_enough(seconds, begin):
        advance = _stepper(candidate, model, scene, q, v, given.force(0.0)).advance
        for load in loads:
            before = time.perf_counter()
            advance(load)
            seconds.append(time.perf_counter() - before)
            if _is_enough(seconds, begin):
                break
    return np.array(seconds[_WARM:])


def batch_rate(candidate: Candidate, model: ReducedModel, scene: Scene) -> float | None:
    """Steps a second of `BATCH` bodies at once, each body's counted; None where there is none."""
    if scene.time.is_static or model.frame is not None:
        return None
    file = Path(candidate.name)
    given = ReducedLoads(model, file, scene)
    q, v = (np.tile(row, (BATCH, 1)) for row in initial_coordinates(model, file, scene))
    loads = [
        np.tile(given.force(i * scene.time.step), (BATCH, 1))
        for i in range(min(scene.time.steps, 20) + 1)
    ]
    seconds = []
    begin = time.perf_counter()
    advance: Callable[[Any], Any] = _stepper(candidate, model, scene, q, v, loads[0]).advance
    for load in loads[1:]:
        before = time.perf_counter()
        advance(load)
        seconds.append(time.perf_counter() - before)
        if len(seconds) >= 3 and time.perf_counter() - begin > _SECONDS:
            break
    return float(BATCH / np.median(seconds))


def _stepper(
    candidate: Candidate, model: ReducedModel, scene: Scene, q: Array, v: Array, load: Array
) -> Any:
    if candidate.kind == FILTER:
        return make_filter(model, scene, q, v, load)
    return make_stepper(model, scene, q, v, load, energies=False)


def _of_motion(begin_motion: Callable[[], Moving], steps: int) -> Array:
    seconds: list[float] = []
    begin = time.perf_counter()
    while not _is_enough(seconds, begin):
        motion = begin_motion()
        for _ in range(steps):
            before = time.perf_counter()
            motion.advance()
            seconds.append(time.perf_counter() - before)
            if _is_enough(seconds, begin):
                break
    return np.array(seconds[min(_WARM, len(seconds) // 2) :])


def _is_enough(seconds: list[float], begin: float) -> bool:
    count = len(seconds)
    late = time.perf_counter() - begin > _SECONDS
    return count >= _WARM + _MOST or (late and count >= _WARM + _FEWEST)


def check_finite(values: Array) -> None:
    """Make sure that a motion has not run away in silence.

    Raises:
        DefoError: it has.
    """
    if not np.isfinite(values).all():
        raise DefoError("its displacements became infinite or no number")
