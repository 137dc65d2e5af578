"""Static equilibrium under loads: f(u) = g(u)."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.simulation import Linear
from fenics_defo.analysis.states import Equilibrium
from fenics_defo.fem import Solid


def static_equilibrium(
    solid: Solid,
    loads: Sequence[Load],
    *,
    prescribed: Sequence[Prescribed] = (),
    load_steps: int = 1,
    tolerance: float = 1e-8,
    max_iterations: int = 50,
    linear: Linear = "cholesky",
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
        max_iterations: of Newton a part.
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
    raise NotImplementedError
