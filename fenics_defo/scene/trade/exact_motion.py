"""A linear model moved through a scene by its exact filter; NumPy only."""

import math
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.states import Energies, State, StepReport
from fenics_defo.runtime import ModalFilter, ReducedModel
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_loads import ReducedLoads, initial_coordinates

Array = NDArray[np.float64]


class ExactMotion:
    """A linear model under way, exactly for loads that go straight from step to step.

    Args:
        model: linear model.
        file: its name, for messages.
        scene: scene.
        phases: stopwatch of "step".

    Raises:
        SceneError: the model does not carry a load or the start of the scene.
    """

    critical_step = math.inf
    energy_error: float | None = None
    energy_gain: float | None = None

    def __init__(self, model: ReducedModel, file: Path, scene: Scene, phases: Phases) -> None:
        self._model, self._scene, self._phases = model, scene, phases
        self._loads = ReducedLoads(model, file, scene)
        self._stiffness = model.stiffness(np.zeros(model.size))
        self._filter = self._begin(*initial_coordinates(model, file, scene), 0.0)
        self.steps = 0

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self.steps * self._scene.time.step

    @property
    def state(self) -> State:
        """The last good state at the nodes that the model stores."""
        moving = self._filter
        fields = [self._model.displacement(values) for values in (moving.q, moving.v, moving.a)]
        return State(self.time, self.steps, *fields)

    @property
    def energies(self) -> Energies:
        """Kinetic and strain energy of the last good state; work is not counted."""
        q, v = self._filter.q, self._filter.v
        kinetic, strain = 0.5 * v @ self._model.mass @ v, 0.5 * q @ self._stiffness @ q
        return Energies(float(kinetic), float(strain), math.nan, math.nan)

    def check_energy(self) -> None:
        """Nothing: the filter gains none."""

    def probe(self, name: str) -> Array:
        """Displacement (3,) [m] of a probe."""
        return self._model.probe(name, self._filter.q)

    def advance(self) -> StepReport:
        """Do one step."""
        begin = time.perf_counter()
        step = self._scene.time.step
        for moment, momentum in self._loads.impulses:
            if self.time - 1e-9 * step <= moment < self.time + step - 1e-9 * step:
                velocity = self._filter.v + np.linalg.solve(self._model.mass, momentum)
                self._filter = self._begin(self._filter.q, velocity, self.time)
        self._filter.advance(self._loads.force(self.time + step))
        self.steps += 1
        self._phases.add("step", time.perf_counter() - begin)
        return StepReport(self.time, self.steps, 0, 0, 0, ())

    def _begin(self, q: Array, v: Array, now: float) -> ModalFilter:
        return make_filter(self._model, self._scene, q, v, self._loads.force(now))


def make_filter(model: ReducedModel, scene: Scene, q: Array, v: Array, load: Array) -> ModalFilter:
    """The exact filter of a linear model in a scene.

    Args:
        model: linear model.
        scene: scene.
        q: coordinates at the start (r,) or (b, r).
        v: velocities there, likewise.
        load: on them there, likewise.
    """
    damping = (scene.damping.mass, scene.damping.stiffness)
    return ModalFilter(
        model, step=scene.time.step, damping=damping, hold="linear", q=q, v=v, load=load
    )
