"""What a body answers to loads about one state: its linear response, and the curvature of it."""

from contextlib import ExitStack
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.eigenpairs import EigenProblem
from fenics_defo.analysis.free_motions import deflated, free_motions, strains_nothing
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.stability import check_unstressed, not_stable
from fenics_defo.errors import SolverError
from fenics_defo.fem import Solid
from fenics_defo.fem.linalg import Factorization, multiply

Array = NDArray[np.float64]


class StaticResponse:
    """A body's tangent about one equilibrium, factorised once; use it in a ``with`` statement.

    A body that is free to move has motions R without stiffness, Rᵀ M R = I. Loads are brought into
    balance by the inertia of a rigid acceleration, (I - M R Rᵀ) g, and the answer's part along R is
    taken out, (I - R Rᵀ M) y. Blocks of vectors are over the components that this rank owns,
    (owned dofs, b) in Fortran order. All is collective.

    Args:
        solid: body.
        displacement: (n, 3) [m] of the equilibrium; rest if not given.
        phases: stopwatch for "assemble", "factorise", "multiply", "solve".

    Raises:
        EigenSolveError: the state is not a stable equilibrium.
        SolverError: the tangent could not be factorised; or the body is free to move and under
            load, where motions of the whole have a stiffness.
    """

    def __init__(
        self, solid: Solid, displacement: Array | None = None, *, phases: Phases | None = None
    ) -> None:
        self._phases = phases or Phases()
        self._assembly, rest = solid.assembly, displacement is None
        if rest:
            check_unstressed(solid)
        state = np.zeros((solid.nodes.size, 3)) if displacement is None else displacement
        self._local = solid.nodes.scatter(np.asarray(state, np.float64))
        with ExitStack() as stack:
            with self._phases("assemble"):
                stiffness = self._assembly.stiffness_matrix(None if rest else self._local)
                stack.callback(stiffness.destroy)
                #: (owned dofs,) bool, components that are not held.
                self.free: NDArray[np.bool_] = ~self._assembly.held[: self._assembly.owned].ravel()
                problem = EigenProblem(
                    stiffness=stiffness,
                    mass=self._assembly.mass,
                    pencil=self._assembly.pencil(stiffness),
                    shift=0.0,
                    definite=rest and solid.is_isotropic_at_rest,
                    independent=int(solid.comm.allreduce(int(self.free.sum()))),
                    free=self.free,
                )
                self._deflation = deflated(solid, problem, free_motions(solid, displacement))
            if displacement is not None and not strains_nothing(
                self._deflation, solid, displacement
            ):
                raise SolverError(
                    "this body is free to move as a whole and loaded in the given state, in which "
                    "rigid motions have a stiffness of their own; hold it, or take the rest shape"
                )
            with self._phases("factorise"):
                self._factors = self._factorised(problem)
            stack.callback(self._factors.close)
            self._derivative = self._assembly.empty_matrix()
            stack.callback(self._derivative.destroy)
            self._stack = stack.pop_all()

    def _factorised(self, problem: EigenProblem) -> Factorization:
        with self._deflation.supported(0.0) as matrix:
            factors = Factorization(matrix, definite=problem.definite)
        if not problem.definite and factors.negative_pivots:
            negative = factors.negative_pivots
            factors.close()
            raise not_stable(negative)
        return factors

    def solve(self, loads: Array) -> Array:
        """K⁻¹ g for a block of loads; without motions that strain nothing. Zero where held."""
        deflation, products = self._deflation, self._deflation.problem.products
        with self._phases("solve"):
            if not deflation.strainless:
                return self._factors.solve(np.asfortranarray(loads))
            motions, momenta = deflation.motions, deflation.momenta
            balanced = loads - momenta @ products(motions, loads)
            answer = self._factors.solve(np.asfortranarray(balanced))
            return np.asfortranarray(answer - motions @ products(momenta, answer))

    def curvature(self, direction: Array, fields: Array) -> Array:
        """(H : d) v for a block of fields v, with (H : d) the tangent's derivative along d.

        Args:
            direction: d (d, 3) over this rank's nodes, ghosts included, zero at held components.
            fields: v (owned dofs, b).

        Returns:
            (owned dofs, b) in Fortran order, zero at held components.
        """
        with self._phases("assemble"):
            self._assembly.fill_tangent_derivative(self._derivative, self._local, direction)
        with self._phases("multiply"):
            return multiply(self._derivative, fields)

    def close(self) -> None:
        """Free factors and matrices; collective."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
