"""A model of a body that nothing holds, in flight through a scene; NumPy only."""

import logging
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.histories import History
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.states import Energies, State, StepReport
from fenics_defo.errors import SceneError
from fenics_defo.runtime import FloatingBody, FloatingFrame, ReducedModel
from fenics_defo.scene.energy_balance import EnergyBalance
from fenics_defo.scene.load_factors import load_factor
from fenics_defo.scene.newton import newton_limits
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reduced_loads import initial_coordinates

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


class ReducedFlight:
    """A model that tumbles and falls under gravity while it deforms.

    It moves by the trapezoidal rule of the floating frame, whatever integrator the scene has for
    the full simulation; damping acts on the deformation alone.

    Args:
        model: model with a floating frame.
        file: its name, for messages.
        scene: scene.
        phases: stopwatch of "step", the steps without the writing.

    Raises:
        SceneError: loads other than gravity, statics, or a start that the model does not carry.
    """

    critical_step = float("inf")

    def __init__(self, model: ReducedModel, file: Path, scene: Scene, phases: Phases) -> None:
        assert model.frame is not None
        _check_scene(scene)
        self._model, self._scene, self._phases = model, scene, phases
        self._frame: FloatingFrame = model.frame
        self._falls: list[tuple[History, Array]] = [
            (load_factor(load.history, scene.time), np.array(load.vector)) for load in scene.loads
        ]
        tolerance, iterations = newton_limits(scene.time)
        given, damping = scene.initial, scene.damping
        self._body = FloatingBody(
            model,
            step=scene.time.step,
            damping=(damping.mass, damping.stiffness),
            newton=scene.time.newton,
            newton_tolerance=tolerance,
            newton_iterations=iterations,
            position=self._frame.centre + np.array(given.displacement),
            velocity=given.velocity,
            angular_velocity=given.spin,
            # What moves the body as a whole has no part in the shapes.
            q=initial_coordinates(model, file, scene)[0],
        )
        self._damping = (damping.mass, damping.stiffness)
        self._external = self._dissipated = 0.0
        self._balance = EnergyBalance(self._energies(), step=scene.time.step)

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        return self._body.time

    @property
    def steps(self) -> int:
        """Number of steps done."""
        return self._body.steps

    @property
    def state(self) -> State:
        """The last good state at the nodes that the model stores; without accelerations."""
        body, frame, model = self._body, self._frame, self._model
        displacement = body.world_displacement()
        arms = model.points + displacement - body.position
        rates = (model.shapes - frame.mean) @ body.v
        velocity = body.velocity + np.cross(body.angular_velocity, arms) + rates @ body.rotation.T
        return State(self.time, self.steps, displacement, velocity, np.zeros_like(velocity))

    @property
    def energies(self) -> Energies:
        """Energies of the last good state."""
        found = self._energies()
        self._balance.look(found)
        return found

    @property
    def energy_error(self) -> float | None:
        """Largest error of the energy balance so far over all energy put in [-]."""
        return self._balance.error

    @property
    def energy_gain(self) -> float | None:
        """The same of what was gained [-]."""
        return self._balance.gain

    def check_energy(self) -> None:
        """Refuse a motion that has run away.

        Raises:
            DivergenceError: it has.
        """
        self._balance.judge(self._energies(), self.time)

    def _energies(self) -> Energies:
        found = self._body.energies
        return Energies(float(found.kinetic), float(found.strain), self._external, self._dissipated)

    def probe(self, name: str) -> Array:
        """Displacement (3,) [m] of a probe."""
        probe, body, frame = self._model.probes[name], self._body, self._frame
        inside = probe.point - frame.centre + (probe.shapes - frame.mean) @ body.q
        return np.asarray(body.position + body.rotation @ inside - probe.point)

    def advance(self) -> StepReport:
        """Do one step.

        Raises:
            DivergenceError: it failed; the last good state stands.
        """
        body, begin = self._body, time.perf_counter()
        place, q, drag, now = body.position, body.q, self._drag(), self._fall(body.time)
        end = self._fall((body.steps + 1) * body.step)
        body.advance(gravity=end)
        moved = self._frame.mass * (body.position - place)
        self._external += float(moved @ (0.5 * (now + end)))
        self._dissipated += float((body.q - q) @ (0.5 * (drag + self._drag())))
        iterations = self._scene.time.newton or 0
        self._phases.add("step", time.perf_counter() - begin)
        if self._balance.is_due(body.steps):
            self.check_energy()
        return StepReport(body.time, body.steps, iterations, iterations, 0, ())

    def _fall(self, at: float) -> Array:
        """Acceleration of gravity (3,) [m/s²]."""
        return sum((history(at) * vector for history, vector in self._falls), np.zeros(3))

    def _drag(self) -> Array:
        """C v of the deformation (r,)."""
        (alpha, beta), body = self._damping, self._body
        drag = alpha * (self._frame.shape_mass @ body.v)
        return drag + beta * (self._model.stiffness(body.q) @ body.v) if beta else drag


def _check_scene(scene: Scene) -> None:
    if scene.time.is_static:
        raise SceneError(
            f'{scene.path}: [time]: nothing holds the body, so integrator = "static" has no place; '
            "choose another integrator"
        )
    for number, load in enumerate(scene.loads, 1):
        if load.kind != "gravity":
            raise SceneError(
                f"{scene.path}: [[load]] {number}: nothing holds the body, and a model in flight "
                f"knows gravity alone, no {load.kind}; leave the load out, hold the body, or step "
                "the model in Python (runtime.FloatingBody takes forces at nodes)"
            )
    method = scene.time
    if method.integrator != "implicit-newmark" or (method.beta, method.gamma) != (0.25, 0.5):
        _log.warning(
            "a model in flight moves by the trapezoidal rule, not by %s", method.integrator
        )
    if scene.damping.mass:
        _log.warning("the mass damping of a model in flight acts on its deformation alone")
