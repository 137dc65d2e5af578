"""A stand-in for a simulation: each node swings, by a recursion of its state alone."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Energies, State, StepReport
from fenics_defo.errors import DivergenceError
from fenics_defo.fem import Solid
from fenics_defo.scene import Scene

Array = NDArray[np.float64]


class Swinging:
    """Has what the runner asks of a simulation."""

    fails_at: int | None = None
    nan_at: int | None = None
    critical_step = np.inf

    def __init__(self, scene: Scene, solid: Solid, *, start: bool = True) -> None:
        self._points, self._step = solid.points, scene.time.step
        self._probes = {probe.name: np.array(probe.point) for probe in scene.probes}
        self.steps, self._work = 0, 0.0
        self._u = np.sin(self._points) if start else np.full_like(self._points, np.nan)
        self._v = np.zeros_like(self._points)
        self.is_closed = False

    @property
    def time(self) -> float:
        return self.steps * self._step

    @property
    def state(self) -> State:
        return State(self.time, self.steps, self._u.copy(), self._v.copy(), -self._u)

    @property
    def energies(self) -> Energies:
        kinetic, strain = float((self._v**2).sum()) / 2, float((self._u**2).sum()) / 2
        return Energies(kinetic, strain, self._work, 0.0)

    @property
    def energy_error(self) -> float:
        return 0.25

    @property
    def energy_gain(self) -> float:
        return 0.125

    def check_energy(self) -> None:
        pass

    def probe(self, name: str) -> Array:
        nearest = np.linalg.norm(self._points - self._probes[name], axis=1).argmin()
        return np.array(self._u[nearest])

    def advance(self) -> StepReport:
        if self.steps + 1 == self.fails_at:
            raise DivergenceError("the step failed", time=self.time, step=self._step)
        self._v -= self._step * np.sin(self._u)
        self._u += self._step * self._v
        if self.steps + 1 == self.nan_at:
            self._u[0] = np.nan
        self.steps += 1
        self._work += float(self._v.sum()) * self._step
        return StepReport(self.time, self.steps, 2, 0, 0, ())

    def restore(self, state: State, energies: Energies) -> None:
        self.steps, self._work = state.step, energies.external
        self._u, self._v = np.array(state.displacement), np.array(state.velocity)

    def close(self) -> None:
        self.is_closed = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
