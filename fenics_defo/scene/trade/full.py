"""Runs of the whole body, kept so that an interrupted one goes on where it was."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Energies, Simulation
from fenics_defo.analysis.states import State
from fenics_defo.energy import Corotational, LinearElastic, Material, PointLaw
from fenics_defo.fem import Solid
from fenics_defo.scene.building import build_simulation, build_solid
from fenics_defo.scene.records import Scene
from fenics_defo.scene.trade.sampling import Sampling
from fenics_defo.scene.trade.store import Store

Array = NDArray[np.float64]

_SAVED_EVERY = 60.0  # seconds on the clock
_LAWS = {"corotational": Corotational, "linear": LinearElastic}
_STATE = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """States of a run at the times of comparison.

    Args:
        displacements: (m, n, 3) [m].
        energies: kinetic and strain (m, 2) [J].
        probes: (m, p, 3) [m].
        seconds: of each step on the clock.
    """

    displacements: Array
    energies: Array
    probes: Array
    seconds: Array


def run_full(
    scene: Scene,
    solid: Solid,
    sampling: Sampling,
    store: Store,
    *,
    halves: int = 1,
    label: str = "",
    moved: Callable[[float], None],
) -> Recorded:
    """Run the whole body, or read what was kept of such a run.

    Args:
        scene: scene, with its own step.
        solid: body.
        sampling: times of comparison.
        store: of what was measured.
        halves: number of parts that each step is divided into.
        label: tells a body of another law or order apart.
        moved: called with the part of the steps that are done.

    Raises:
        DivergenceError: a step failed.
    """
    key = {"full": label, "halves": halves, "stride": sampling.stride}
    kept = store.arrays({**key, "whole": True})
    if kept is not None:
        moved(1.0)
        return Recorded(**kept)
    finer = replace(scene, time=replace(scene.time, step=scene.time.step / halves))
    begun = store.arrays({**key, "whole": False})
    with contextlib.closing(build_simulation(finer, solid, start=begun is None)) as simulation:
        run = _Run(simulation, finer, sampling, halves)
        if begun is not None:
            run.go_on(begun)
        try:
            run.finish(moved, lambda: store.keep_arrays({**key, "whole": False}, run.begun()))
        except KeyboardInterrupt:
            store.keep_arrays({**key, "whole": False}, run.begun())
            raise
    store.keep_arrays({**key, "whole": True}, run.arrays())
    store.path({**key, "whole": False}, ".npz").unlink(missing_ok=True)
    return Recorded(**run.arrays())


def with_law(scene: Scene, solid: Solid, law: str) -> tuple[Scene, Solid]:
    """The scene and its body with another law of the same small strains.

    Args:
        scene: scene.
        solid: its body.
        law: "corotational" or "linear".
    """
    materials = scene.materials or solid.record.materials
    other: dict[Any, Any] = {}
    for region, material in materials.items():
        assert isinstance(material, Material | PointLaw)  # it is isotropic at rest
        young, poisson = material.linearised()
        other[region] = _LAWS[law](young=young, poisson=poisson, density=material.density)
    changed = replace(scene, materials=other)
    return changed, build_solid(changed)


class _Run:
    """A simulation under way, and the states that it has passed."""

    def __init__(
        self, simulation: Simulation, scene: Scene, sampling: Sampling, halves: int
    ) -> None:
        self._simulation, self._names = simulation, [probe.name for probe in scene.probes]
        self._stride, self._steps = sampling.stride * halves, sampling.steps * halves
        self._states: list[Array] = []
        self._energies: list[tuple[float, float]] = []
        self._probes: list[list[Array]] = []
        self._seconds: list[float] = []

    def go_on(self, begun: dict[str, Array]) -> None:
        """Take up what was kept."""
        moment, step = float(begun["clock"][0]), int(begun["clock"][1])
        state = State(moment, step, *begun["state"])
        self._simulation.restore(state, Energies(*begun["now"].tolist()))
        self._states = list(begun["displacements"])
        self._energies = [(float(a), float(b)) for a, b in begun["energies"]]
        self._probes = [list(row) for row in begun["probes"]]
        self._seconds = begun["seconds"].tolist()

    def finish(self, moved: Callable[[float], None], save: Callable[[], None]) -> None:
        """Do all the steps that are left."""
        simulation, saved = self._simulation, time.monotonic()
        if not self._states:
            self._record()
        while simulation.steps < self._steps:
            begin = time.perf_counter()
            simulation.advance()
            self._seconds.append(time.perf_counter() - begin)
            if simulation.steps % self._stride == 0:
                self._record()
            if time.monotonic() - saved >= _SAVED_EVERY:
                save()
                saved = time.monotonic()
            moved(simulation.steps / self._steps)

    def arrays(self) -> dict[str, Array]:
        """All that was recorded."""
        shape = (len(self._states), len(self._names), 3)
        return {
            "displacements": np.array(self._states),
            "energies": np.array(self._energies),
            "probes": np.array(self._probes).reshape(shape),
            "seconds": np.array(self._seconds),
        }

    def begun(self) -> dict[str, Array]:
        """The same with the state that the run goes on from."""
        state, now = self._simulation.state, self._simulation.energies
        return {
            **self.arrays(),
            "clock": np.array([state.time, state.step]),
            "state": np.array([getattr(state, name) for name in _STATE]),
            "now": np.array([now.kinetic, now.strain, now.external, now.dissipated]),
        }

    def _record(self) -> None:
        simulation = self._simulation
        energies = simulation.energies
        self._states.append(simulation.state.displacement)
        self._energies.append((energies.kinetic, energies.strain))
        self._probes.append([simulation.probe(name) for name in self._names])
