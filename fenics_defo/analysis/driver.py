"""A whole simulation in one call."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple

import numpy as np
from numpy.typing import ArrayLike

from fenics_defo.analysis.initial import Initial
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.simulation import Simulation
from fenics_defo.analysis.states import EnergyRecord, Motion, StepReport
from fenics_defo.errors import StepSizeError
from fenics_defo.fem import Solid
from fenics_defo.fem.linear_solvers import Kind


def simulate(
    solid: Solid,
    loads: Sequence[Load],
    integrator: Integrator,
    *,
    step: float,
    duration: float,
    damping: tuple[float, float] = (0.0, 0.0),
    newton: int | None = 1,
    newton_tolerance: float = 1e-6,
    newton_iterations: int = 20,
    linear: Kind = "cholesky",
    linear_tolerance: float = 1e-6,
    initial: Initial | None = None,
    prescribed: Sequence[Prescribed] = (),
    probes: Mapping[str, ArrayLike] | None = None,
    max_halvings: int = 6,
    allow_unstable: bool = False,
    energies_every: int = 1,
    observe: Callable[[Simulation], None] | None = None,
) -> Motion:
    """Move a body for some time; see `Simulation` for what the arguments mean.

    Collective; the same result on each rank.

    Args:
        solid: body.
        loads: what acts on it.
        integrator: method.
        step: time step [s].
        duration: [s]; rounded to whole steps.
        damping: (alpha [1/s], beta [s]).
        newton: iterations a step; None: until ``newton_tolerance``.
        newton_tolerance: relative residual [-].
        newton_iterations: most iterations of converged Newton with full steps; the search that
            is tried after them may take three times as many.
        linear: linear solver.
        linear_tolerance: relative residual [-].
        initial: displacement and velocity at time zero.
        prescribed: displacements prescribed in time.
        probes: points at rest [m] by name.
        max_halvings: how often a failed step may be halved.
        allow_unstable: go on beyond an explicit method's limit.
        energies_every: record energies each so many steps; 0: never (they cost an assembly, which
            the watch on their balance takes every few steps only).
        observe: called with the simulation at the start and after each step.

    Returns:
        times, probes, energies, the last state and a report a step.

    Raises:
        DivergenceError: a step failed however often it was halved, or the energy has run away.
        LoadError: loads or prescribed motions that this body cannot take.
        StepSizeError: a step that is not positive, or beyond an explicit method's limit.
        SelectionError: a region that the mesh does not have.
    """
    steps = _whole_steps(step, duration)
    if energies_every < 0 or isinstance(energies_every, bool):
        raise StepSizeError(f"energies_every must be a whole number from 0, got {energies_every!r}")
    with Simulation(
        solid,
        loads,
        integrator,
        step=step,
        damping=damping,
        newton=newton,
        newton_tolerance=newton_tolerance,
        newton_iterations=newton_iterations,
        linear=linear,
        linear_tolerance=linear_tolerance,
        initial=initial,
        prescribed=prescribed,
        probes=probes,
        max_halvings=max_halvings,
        allow_unstable=allow_unstable,
    ) as simulation:
        return _run(simulation, steps, energies_every, observe)


def _whole_steps(step: float, duration: float) -> int:
    """How many steps a duration has.

    Raises:
        StepSizeError: none, or one of the two is not positive and finite.
    """
    for name, value in (("step", step), ("duration", duration)):
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (is_number and 0.0 < value < math.inf):
            raise StepSizeError(f"the {name} must be positive and finite [s], got {value!r}")
    if not duration >= 0.5 * step:
        raise StepSizeError(
            f"a duration of {duration:g} s has no step of {step:g} s; take a smaller step"
        )
    return round(duration / step)


def _run(
    simulation: Simulation,
    steps: int,
    energies_every: int,
    observe: Callable[[Simulation], None] | None,
) -> Motion:
    times = np.empty(steps + 1)
    probes = {name: np.empty((steps + 1, 3)) for name in simulation.probe_names}
    energies: list[tuple[float, ...]] = []
    reports: list[StepReport] = []
    for number in range(steps + 1):
        if number:
            reports.append(simulation.advance())
        times[number] = simulation.time
        for name, values in probes.items():
            values[number] = simulation.probe(name)
        if energies_every and number % energies_every == 0:
            energies.append((simulation.time, *astuple(simulation.energies)))
        if observe is not None:
            observe(simulation)
    simulation.check_energy()
    columns = np.array(energies).reshape(-1, 5).T
    return Motion(
        times=times,
        probes=probes,
        energies=EnergyRecord(*columns),
        state=simulation.state,
        reports=tuple(reports),
        energy_error=simulation.energy_error,
        energy_gain=simulation.energy_gain,
    )
