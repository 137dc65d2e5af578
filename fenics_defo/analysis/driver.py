"""A whole simulation in one call."""

from collections.abc import Callable, Mapping, Sequence

from numpy.typing import ArrayLike

from fenics_defo.analysis.initial import Initial
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.simulation import Linear, Simulation
from fenics_defo.analysis.states import Motion
from fenics_defo.fem import Solid


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
    linear: Linear = "cholesky",
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
        newton_iterations: most iterations.
        linear: linear solver.
        linear_tolerance: relative residual [-].
        initial: displacement and velocity at time zero.
        prescribed: displacements prescribed in time.
        probes: points at rest [m] by name.
        max_halvings: how often a failed step may be halved.
        allow_unstable: go on beyond an explicit method's limit.
        energies_every: record energies each so many steps; 0: never (they cost an assembly).
        observe: called with the simulation at the start and after each step.

    Returns:
        times, probes, energies, the last state and a report a step.

    Raises:
        DivergenceError: a step failed however often it was halved.
        LoadError: loads or prescribed motions that this body cannot take.
        StepSizeError: a step that is not positive, or beyond an explicit method's limit.
        SelectionError: a region that the mesh does not have.
    """
    raise NotImplementedError
