"""A body in motion, or on its way to equilibrium: one step at a time."""

from collections.abc import Mapping, Sequence
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.analysis.initial import Initial
from fenics_defo.analysis.integrators.integrator import Integrator
from fenics_defo.analysis.loads import Load
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.analysis.states import Energies, State, StepReport
from fenics_defo.fem import Solid

Array = NDArray[np.float64]
Linear = Literal["cholesky", "pcg-jacobi", "pcg-amg"]


class Simulation:
    """Motion of a body under loads, M a + C v + f(u) = g(t, u), step by step.

    C = alpha M + beta K(u) is Rayleigh's damping with the current tangent. Everything is collective
    on ``solid.comm``. Use it in a ``with`` statement, or `close` it.

    Args:
        solid: body.
        loads: what acts on it.
        integrator: `ImplicitNewmark`, `BackwardEuler`, `CentralDifferences`, `SymplecticEuler`, or
            `QuasiStatic`.
        step: time step [s].
        damping: (alpha [1/s], beta [s]).
        newton: number of Newton iterations a step; 1 is semi-implicit: one linearised solve a step,
            whose residual is not looked at. None iterates until ``newton_tolerance`` is met.
        newton_tolerance: relative residual of converged Newton [-].
        newton_iterations: most iterations of converged Newton.
        linear: solver of the linear systems.
        linear_tolerance: relative residual of conjugate gradients [-].
        initial: displacement and velocity at time zero.
        prescribed: displacements prescribed in time.
        probes: points at rest [m] by name; `probe` gives their displacements.
        max_halvings: how often a failed step may be halved.
        allow_unstable: go on where an explicit method's step is beyond its limit.

    Raises:
        LoadError: loads or prescribed motions that this body cannot take.
        StepSizeError: a step that is not positive, or beyond an explicit method's limit.
        SelectionError: a region that the mesh does not have.
    """

    def __init__(
        self,
        solid: Solid,
        loads: Sequence[Load],
        integrator: Integrator,
        *,
        step: float,
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
    ) -> None:
        raise NotImplementedError

    @property
    def time(self) -> float:
        """Time of the last good state [s]."""
        raise NotImplementedError

    @property
    def steps(self) -> int:
        """Number of steps done since time zero."""
        raise NotImplementedError

    @property
    def critical_step(self) -> float:
        """Largest stable step of an explicit method at the start [s]; infinite for others."""
        raise NotImplementedError

    @property
    def state(self) -> State:
        """The last good state; collective."""
        raise NotImplementedError

    @property
    def energies(self) -> Energies:
        """Energies of the last good state; collective, assembles the strain energy."""
        raise NotImplementedError

    def probe(self, name: str) -> Array:
        """Displacement (3,) [m] of a probe; collective."""
        raise NotImplementedError

    def momentum(self) -> tuple[Array, Array]:
        """Momentum (3,) [kg m/s], and angular momentum (3,) about the origin [kg m²/s]."""
        raise NotImplementedError

    def advance(self) -> StepReport:
        """Do one step.

        Raises:
            DivergenceError: it failed however often it was halved; the last good state stands.
            StepSizeError: an explicit method's limit has fallen below the step.
        """
        raise NotImplementedError

    def restore(self, state: State, energies: Energies) -> None:
        """Go on from a state that this simulation, or another of the same kind, gave out.

        With the direct solver the numbers that follow are those of the uninterrupted run, bit by
        bit on the same number of ranks.

        Raises:
            LoadError: arrays of another shape, or not finite.
        """
        raise NotImplementedError

    def close(self) -> None:
        """Free the matrices and the solver; collective."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
