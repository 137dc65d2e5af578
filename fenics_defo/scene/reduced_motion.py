"""A model moved through a scene, as the loop over the steps of a run sees it; NumPy only."""

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.states import Energies, State, StepReport
from fenics_defo.errors import LoadError, SolverError, StepSizeError
from fenics_defo.runtime import ReducedModel
from fenics_defo.runtime.integrators import (
    BackwardEuler,
    CentralDifferences,
    ImplicitNewmark,
    Stepper,
    SymplecticEuler,
)
from fenics_defo.scene.energy_balance import EnergyBalance
from fenics_defo.scene.newton import newton_limits
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_loads import ReducedLoads, initial_coordinates
from fenics_defo.scene.reduced_statics import ReducedStatics
from fenics_defo.scene.schema import EXPLICIT

Array = NDArray[np.float64]


class ReducedMotion:
    """A model under way through the equations of motion or through equilibria.

    Args:
        model: model.
        file: its name, for messages.
        scene: scene.
        phases: stopwatch of "step", the steps without the writing.

    Raises:
        SceneError: the model does not carry a load or the start of the scene.
        StepSizeError: the step is beyond what an explicit integrator stands.
    """

    def __init__(self, model: ReducedModel, file: Path, scene: Scene, phases: Phases) -> None:
        self._model, self._scene, self._phases = model, scene, phases
        self._loads = ReducedLoads(model, file, scene)
        q, v = initial_coordinates(model, file, scene)
        self._last: tuple[Array, Array] | None = None
        self._body: ReducedStatics | Stepper
        if scene.time.is_static:
            tolerance, iterations = newton_limits(scene.time)
            self._body = ReducedStatics(
                model,
                self._loads.force,
                q=q,
                step=scene.time.step,
                tolerance=tolerance,
                iterations=iterations,
            )
        else:
            self._body = _stepper(model, scene, q, v, self._loads.force(0.0))
        self._balance = EnergyBalance(
            self._energies(),
            step=scene.time.step,
            limit=self.critical_step,
            lenient=scene.time.allow_unstable,
        )

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self._body.time

    @property
    def steps(self) -> int:
        """Number of steps done."""
        return self._body.steps

    @property
    def critical_step(self) -> float:
        """Largest stable step [s]; infinite for implicit methods."""
        return float(getattr(self._body, "critical_step", math.inf))

    @property
    def state(self) -> State:
        """The last good state at the nodes that the model stores."""
        model, body = self._model, self._body
        fields = [model.displacement(values) for values in (body.q, body.v, body.a)]
        return State(self.time, self.steps, *fields)

    @property
    def energies(self) -> Energies:
        """Energies of the last good state."""
        found = self._energies()
        self._balance.look(found)
        return found

    @property
    def energy_error(self) -> float | None:
        """Largest error of the energy balance so far over all energy put in [-]; None: statics."""
        return None if self._scene.time.is_static else self._balance.error

    @property
    def energy_gain(self) -> float | None:
        """The same of what was gained [-]."""
        return None if self._scene.time.is_static else self._balance.gain

    def check_energy(self) -> None:
        """Refuse a motion that has run away.

        Raises:
            DivergenceError: it has.
        """
        if not self._scene.time.is_static:
            self._balance.judge(self._energies(), self.time)

    def _energies(self) -> Energies:
        found = self._body.energies
        names = ("kinetic", "strain", "external", "dissipated")
        kinetic, strain, external, dissipated = (float(getattr(found, name)) for name in names)
        return Energies(kinetic, strain, external + self._work_ahead(), dissipated)

    def probe(self, name: str) -> Array:
        """Displacement (3,) [m] of a probe."""
        return self._model.probe(name, self._body.q)

    def advance(self) -> StepReport:
        """Do one step.

        Raises:
            DivergenceError: it failed; the last good state stands.
        """
        body, begin = self._body, time.perf_counter()
        if isinstance(body, ReducedStatics):
            body.advance()
            iterations, halvings = body.iterations, body.halvings
        else:
            self._strike(body)
            load = self._loads.force(body.load_time)
            before = body.q if body.load_at_start else None
            body.advance(load)
            self._last = None if before is None else (body.q - before, load)
            iterations, halvings = self._solves(body), 0
        self._phases.add("step", time.perf_counter() - begin)
        if self._balance.is_due(body.steps):
            self.check_energy()
        return StepReport(body.time, body.steps, iterations, iterations, halvings, ())

    def _solves(self, body: Stepper) -> int:
        """Linear solves of the last step."""
        given = self._scene.time
        if given.integrator in EXPLICIT:
            return 0
        return body.iterations if given.newton is None else given.newton

    def _work_ahead(self) -> float:
        """What a method that knows the loads of starts only lacks in the work of the last step.

        It has taken that of the last start for that at the end.
        """
        if self._last is None:
            return 0.0
        change, load = self._last
        return 0.5 * float(change @ (self._loads.force(self.time) - load))

    def _strike(self, body: Stepper) -> None:
        """The impulses of a step act at its start."""
        start, tiny = body.time, 1e-9 * body.step
        for moment, momentum in self._loads.impulses:
            if start - tiny <= moment < start + body.step - tiny:
                body.kick(momentum, load=self._loads.force(start))


def _stepper(model: ReducedModel, scene: Scene, q: Array, v: Array, load: Array) -> Stepper:
    """The scene's integrator on a model."""
    given = scene.time
    common: dict[str, Any] = {
        "step": given.step,
        "damping": (scene.damping.mass, scene.damping.stiffness),
        "q": q,
        "v": v,
        "load": load,
        "energies": True,
    }
    tolerance, iterations = newton_limits(given)
    rates: dict[str, Any] = {"beta": given.beta, "gamma": given.gamma}
    newton: dict[str, Any] = {
        "newton": given.newton,
        "newton_tolerance": tolerance,
        "newton_iterations": iterations,
    }
    try:
        match given.integrator:
            case "implicit-newmark":
                return ImplicitNewmark(model, **common, **newton, **rates)
            case "backward-euler":
                return BackwardEuler(model, **common, **newton)
            case "central-differences":
                return CentralDifferences(model, **common, allow_unstable=given.allow_unstable)
        return SymplecticEuler(model, **common, allow_unstable=given.allow_unstable)
    except (LoadError, SolverError, StepSizeError) as error:
        raise type(error)(f"{scene.path}: [time]: {error}") from error
