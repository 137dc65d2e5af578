"""Vibration modes of a body: K φ = ω² M φ, solved, normalised, ordered and checked."""

import logging
from dataclasses import dataclass, replace
from typing import Literal, get_args

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.inertia import Inertia, body_inertia
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.rigid import free_motions
from fenics_defo.analysis.slepc import krylov_schur
from fenics_defo.analysis.spectrum import align_clusters, cluster_end, quadratic_fields, signs
from fenics_defo.errors import DefoError, EigenSolveError
from fenics_defo.fem import Solid
from fenics_defo.fem.linalg import multiply
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]
Solver = Literal["lanczos", "krylov-schur", "iterative"]

_log = logging.getLogger(__name__)

# λ of a rigid motion relative to the estimate of the first elastic one: ω below 1e-4 of it.
_RIGID = 1e-8
# The shift of a free body, as a part of that estimate.
_SHIFT = 0.05
# Pairs computed beyond those asked for: they show where a cluster ends and where to count.
_GUARD = 2
# λ that differ by less are one eigenvalue, whose vectors may be rotated among each other.
_SAME = 1e-9
_ATTEMPTS = 4
# Error of the shifted and inverted eigenvalues: the residuals stay near the factorisation's
# round-off.
_TOLERANCE = 1e-7
_ITERATIVE_TOLERANCE = 1e-7


def linear_modes(
    solid: Solid,
    count: int,
    *,
    displacement: Array | None = None,
    solver: Solver = "lanczos",
    keep_rigid: bool = True,
    verify: bool = True,
    residual_tolerance: float = 1e-6,
    cluster_tolerance: float = 1e-4,
    seed: int = 0,
    phases: Phases | None = None,
) -> Modes:
    """Lowest undamped vibration modes about the rest shape, or about a stable deformed state.

    Solves K φ = ω² M φ with K the tangent stiffness and M the consistent mass; held components are
    eliminated (their eigenvalues lie at infinity). A body with free rigid motions is solved about a
    small negative shift. Collective on ``solid.comm``; the same result on each rank.

    Args:
        solid: body.
        count: number of modes, rigid ones included if they are kept. A cluster of equal frequencies
            is never cut: its last members are returned beyond ``count``.
        displacement: (n, 3) [m] of the state that the body vibrates about (pre-stress); rest if not
            given.
        solver: "lanczos": block Lanczos, shift and invert, factors by MUMPS; "krylov-schur":
            SLEPc's, with the same factors, one vector at a time; "iterative": block Lanczos with
            inner solves by conjugate gradients and an algebraic multigrid that knows the rigid
            motions, for bodies whose factors do not fit into memory.
        keep_rigid: keep the rigid modes of a free body, as the first of the list.
        verify: prove by an inertia count of K - σ M above the last mode that none is missing; one
            more factorisation. Not with the iterative solver.
        residual_tolerance: largest accepted relative residual ‖Kφ - ω²Mφ‖ / ‖ω²Mφ‖ of a mode [-].
        cluster_tolerance: relative distance of frequencies that count as equal [-].
        seed: of the random start vectors.
        phases: stopwatch for "assemble", "factorise", "solve", "count".

    Returns:
        the modes over the nodes in the user's order.

    Raises:
        DefoError: ``count`` or ``solver`` out of range, ``displacement`` of the wrong shape.
        EigenSolveError: modes did not converge, are missing or inaccurate, or the state is not
            stable.
        SolverError: the stiffness could not be factorised.
    """
    phases = phases or Phases()
    if solver not in get_args(Solver):
        raise DefoError(f"solver must be one of {', '.join(get_args(Solver))}, got {solver!r}")
    with phases("assemble"):
        body = _prepare(solid, displacement)
    with body.problem:
        limit = body.problem.independent - (0 if keep_rigid else body.rigid)
        if not (isinstance(count, int | np.integer) and 1 <= count <= limit):
            raise DefoError(
                f"count must be a whole number from 1 to {limit}, the motions of this body, got {count!r}"
            )
        total = int(count) + (0 if keep_rigid else body.rigid)
        search = _Search(body, solver, total, 2.0 * cluster_tolerance, seed, phases)
        pairs, complete = search.run(verify=verify and solver != "iterative")
        modes = _modes(body, pairs, complete=complete, residual_tolerance=residual_tolerance)
    return modes if keep_rigid else modes.select(slice(modes.rigid_modes, None))


@dataclass(frozen=True, slots=True)
class _Body:
    """What a search needs to know of a body.

    Args:
        solid: the body.
        problem: its matrices and shift.
        inertia: its masses.
        rigid: number of rigid motions that its constraints leave.
        scale: estimate of the first elastic λ, from above [rad²/s²]; 0 for a held body.
        fields: (owned dofs, 30) polynomial displacements, zero at held components.
    """

    solid: Solid
    problem: EigenProblem
    inertia: Inertia
    rigid: int
    scale: float
    fields: Array


def _prepare(solid: Solid, displacement: Array | None) -> _Body:
    """Assemble a body's matrices and choose the shift."""
    if displacement is not None:
        solid.internal_force(displacement)  # raises for a wrong shape
    assembly = solid.assembly
    owned = assembly.owned
    free = ~assembly.held[:owned].ravel()
    local = None if displacement is None else solid.nodes.scatter(np.asarray(displacement))
    points = solid.points if displacement is None else solid.points + displacement
    rigid = free_motions(points, solid.cells, solid.held)
    inertia = body_inertia(solid)
    place = solid.nodes.scatter(points)[:owned] - inertia.centre
    size = solid.comm.allreduce(float(np.abs(place).max(initial=0.0)), op=MPI.MAX)
    fields = np.asfortranarray(quadratic_fields(place / size).reshape(30, -1).T * free[:, None])
    problem = EigenProblem(
        stiffness=assembly.stiffness_matrix(local),
        mass=assembly.mass_matrix(),
        shift=0.0,
        definite=displacement is None,
        independent=int(solid.comm.allreduce(int(free.sum()))),
        free=free,
    )
    scale = _first_elastic(problem, fields, rigid) if rigid else 0.0
    problem = replace(problem, shift=-_SHIFT * scale)
    return _Body(solid, problem, inertia, rigid, scale, fields)


def _first_elastic(problem: EigenProblem, fields: Array, rigid: int) -> float:
    """Rayleigh-Ritz estimate, from above, of the first λ that is no rigid motion's."""
    stiffness = problem.products(fields, multiply(problem.stiffness, fields))
    mass = problem.products(fields, multiply(problem.mass, fields))
    weight = np.sqrt(np.maximum(np.diag(mass), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(mass / np.outer(weight, weight))
    kept = values > 1e-10
    turn = vectors[:, kept] / weight[:, None] / np.sqrt(values[kept])
    ritz = np.linalg.eigvalsh(turn.T @ stiffness @ turn)
    return float(ritz[min(rigid, len(ritz) - 1)])


@dataclass(frozen=True, slots=True)
class _Search:
    """The search for the lowest ``total`` pairs and what completes their last cluster."""

    body: _Body
    solver: Solver
    total: int
    cluster_rtol: float
    seed: int
    phases: Phases

    def run(self, *, verify: bool) -> tuple[Pairs, bool]:
        """Pairs with whole clusters, and whether a count has proved them complete.

        Raises:
            EigenSolveError: the count never agreed with the pairs found.
        """
        problem = self.body.problem
        wanted = self.total
        found = expected = 0
        for attempt in range(_ATTEMPTS):
            pairs = self._solve(min(wanted, problem.independent), self.seed + attempt)
            values = np.where(pairs.values < _RIGID * self.body.scale, 0.0, pairs.values)
            end = cluster_end(values, self.total, rtol=self.cluster_rtol)
            if end > pairs.converged or end == len(values) < problem.independent:
                wanted = end + 2 + end // 8  # the last cluster goes on
                continue
            kept = replace(pairs.leading(end), values=values[:end])
            if not verify:
                return kept, False
            found = end
            with self.phases("count"):
                expected = problem.below(self._cut(values, end))
            if expected == found:
                return kept, True
            _log.info("found %d modes where the inertia counts %d: searching on", found, expected)
            wanted = max(expected, self.total) + 2 * _GUARD
        raise EigenSolveError(
            f"{found} modes were found where the inertia of the shifted stiffness counts {expected}, in {_ATTEMPTS} "
            "attempts; ask for a few more or fewer modes, or check the mesh for parts that hardly hold together"
        )

    def _solve(self, count: int, seed: int) -> Pairs:
        problem, phases = self.body.problem, self.phases
        match self.solver:
            case "lanczos":
                return problem.lanczos(
                    count, guard=_GUARD, tolerance=_TOLERANCE, seed=seed, phases=phases
                )
            case "krylov-schur":
                more = min(count + _GUARD, problem.independent)
                return krylov_schur(problem, more, tolerance=_TOLERANCE, phases=phases)
        return problem.multigrid_lanczos(
            count,
            self.body.fields[:, :6],
            guard=_GUARD,
            tolerance=_ITERATIVE_TOLERANCE,
            seed=seed,
            phases=phases,
        )

    def _cut(self, values: Array, end: int) -> float:
        """A value between the last kept eigenvalue and the next."""
        last = float(values[end - 1])
        if end < len(values):
            return 0.5 * (last + float(values[end]))
        return max(1.01 * last, 1e-3 * self.body.scale)


def _modes(body: _Body, pairs: Pairs, *, complete: bool, residual_tolerance: float) -> Modes:
    """The user's record of the pairs, after the checks that it must stand."""
    solid, problem, inertia = body.solid, body.problem, body.inertia
    projections = problem.products(pairs.momenta, body.fields)
    pairs = pairs.rotated(align_clusters(pairs.values, projections, rtol=_SAME))
    residuals = _checked_residuals(body, pairs, residual_tolerance)
    rigid = int(np.count_nonzero(pairs.values == 0.0))
    if rigid < min(body.rigid, len(pairs.values)):
        raise EigenSolveError(
            f"{body.rigid} rigid motions are free, but only {rigid} modes have no stiffness; the mesh may be too "
            "large or too small for its units (metres)"
        )
    if rigid > body.rigid:
        _log.warning(
            "%d modes have no stiffness where %d rigid motions are free: parts of the body hang together by a "
            "node or an edge only, like a hinge",
            rigid,
            body.rigid,
        )
    local = pairs.vectors.reshape(-1, 3, pairs.vectors.shape[1])
    shapes = np.ascontiguousarray(np.moveaxis(solid.nodes.gather(local), 2, 0))
    sign = signs(shapes)
    numbers = np.zeros(solid.nodes.size, np.int64)
    numbers[: len(solid.record.node_numbers)] = solid.record.node_numbers
    return Modes(
        frequencies=np.sqrt(pairs.values) / (2.0 * np.pi),
        shapes=shapes * sign[:, None, None],
        points=solid.points,
        cells=solid.cells,
        cell_type=solid.nodes.cell_type,
        node_numbers=numbers,
        node_mass=solid.lumped_mass(),
        residuals=residuals,
        rigid_modes=rigid,
        complete=complete,
        participation=problem.products(pairs.vectors, inertia.momenta) * sign[:, None],
        total_mass=inertia.total_mass,
        centre=inertia.centre,
        inertia=inertia.moments,
    )


def _checked_residuals(body: _Body, pairs: Pairs, tolerance: float) -> Array:
    problem = body.problem
    elastic = pairs.values[pairs.values > 0.0]
    floor = float(elastic[0]) if elastic.size else body.scale
    residuals = problem.residuals(pairs, floor)
    if not (residuals <= tolerance).all():
        worst = int(np.argmax(np.nan_to_num(residuals, nan=np.inf)))
        raise EigenSolveError(
            f"mode {worst + 1} has the relative residual {residuals[worst]:.1e}, and {tolerance:.1e} is allowed; "
            "the mesh may hold slivers or materials of too different stiffness; "
            "improve it, or allow a larger residual_tolerance"
        )
    gram = problem.products(pairs.vectors, pairs.momenta)
    worst_product = float(np.abs(gram - np.eye(len(gram))).max())
    if not worst_product <= 1e-8:
        raise EigenSolveError(
            f"the modes are orthonormal to {worst_product:.1e} only, 1e-8 is allowed"
        )
    return residuals
