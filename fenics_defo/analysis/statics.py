"""Static equilibrium under loads: f(u) = g(u)."""

import logging
from collections.abc import Sequence
from dataclasses import replace

from numpy.typing import ArrayLike

from fenics_defo.analysis.applied_loads import as_loads
from fenics_defo.analysis.histories import Ramp
from fenics_defo.analysis.initial import Initial
from fenics_defo.analysis.instant import StepFailure
from fenics_defo.analysis.integrators import QuasiStatic
from fenics_defo.analysis.inversion import count_inverted
from fenics_defo.analysis.loads import Impulse, Load
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.simulation import Simulation
from fenics_defo.analysis.states import Equilibrium, Substep
from fenics_defo.errors import DivergenceError, LoadError
from fenics_defo.fem import Solid
from fenics_defo.fem.linear_solvers import Kind

_log = logging.getLogger(__name__)

_ADVICE = (
    "The body may buckle or collapse there; try more steps of the load, a smaller load, a start "
    "from a displacement near the equilibrium, or a damped motion towards it (backward Euler with "
    "a mass damping)"
)


def static_equilibrium(
    solid: Solid,
    loads: Sequence[Load],
    *,
    prescribed: Sequence[Prescribed] = (),
    load_steps: int = 1,
    tolerance: float = 1e-8,
    max_iterations: int = 50,
    linear: Kind = "cholesky",
    linear_tolerance: float = 1e-10,
    initial: ArrayLike | None = None,
    max_halvings: int = 10,
) -> Equilibrium:
    """Find the displacement at which a body rests under its loads.

    Newton's method with a line search, in ``load_steps`` equal parts of the load; a part that fails
    is halved. Histories are not looked at: loads and prescribed displacements come in full.
    Collective; the same result on each rank.

    Args:
        solid: body.
        loads: dead loads and following pressures; impulses have no place here.
        prescribed: prescribed displacements.
        load_steps: number of parts.
        tolerance: residual relative to the loads and reactions [-].
        max_iterations: of Newton a part, with full steps; a search then, three times as many.
        linear: linear solver.
        linear_tolerance: relative residual of conjugate gradients [-].
        initial: displacement (n, 3) [m] to start from; rest if not given.
        max_halvings: how often a part may be halved.

    Returns:
        the equilibrium.

    Raises:
        DivergenceError: none was found, however small the part of the load.
        LoadError: loads that this body cannot take.
        SelectionError: a region that the mesh does not have.
    """
    if isinstance(load_steps, bool) or not (isinstance(load_steps, int) and load_steps >= 1):
        raise LoadError(f"load_steps must be a whole number from 1, got {load_steps!r}")
    whole = Ramp(1.0)  # the load's part is a time from 0 to 1
    substeps: list[Substep] = []
    iterations = 0
    with Simulation(
        solid,
        [_with_history(load, whole) for load in as_loads(loads)],
        QuasiStatic(),
        step=1.0 / load_steps,
        newton=None,
        newton_tolerance=tolerance,
        newton_iterations=max_iterations,
        linear=linear,
        linear_tolerance=linear_tolerance,
        initial=None if initial is None else Initial(displacement=initial),
        prescribed=[replace(motion, history=whole) for motion in prescribed],
        max_halvings=max_halvings,
    ) as simulation:
        try:
            for _ in range(load_steps):
                report = simulation.advance()
                substeps += report.substeps
                iterations += report.newton_iterations
        except DivergenceError as error:
            raise _not_found(error) from error
        displacement = simulation.state.displacement
        inverted = count_inverted(solid, displacement)
        if inverted:
            _log.warning(
                "%d cells are inside out in this equilibrium: the law does not resist it", inverted
            )
        return Equilibrium(
            displacement=displacement,
            reactions=simulation.reactions(),
            strain_energy=simulation.energies.strain,
            load_factors=tuple(substep.time for substep in substeps),
            residuals=tuple(substep.residuals for substep in substeps),
            iterations=iterations,
            definite=simulation.is_definite(),
            inverted_cells=inverted,
        )


def _with_history(load: Load, history: Ramp) -> Load:
    if isinstance(load, Impulse):
        raise LoadError("an impulse has no part in an equilibrium; simulate the motion instead")
    return replace(load, history=history)


def _not_found(error: DivergenceError) -> DivergenceError:
    history = ", ".join(f"{residual:.1e}" for residual in error.residuals[-8:])
    said = f" (relative residuals {history})" if history else ""
    message = f"no equilibrium was found beyond {error.time:.4g} of the load"
    if isinstance(error.__cause__, StepFailure) and error.__cause__.lasting:
        message = f"{message}: {error.reason}"
    else:
        message = (
            f"{message}, in parts as small as {error.step:.2g}: {error.reason}{said}. {_ADVICE}"
        )
    return DivergenceError(
        message,
        time=error.time,
        step=error.step,
        residuals=error.residuals,
        reason=error.reason,
    )
