"""Vibration modes of a body: K φ = ω² M φ, solved, normalised, ordered and checked."""

from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.checks import checked_pairs
from fenics_defo.analysis.deflation import Deflation
from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.free_motions import deflated, free_motions, strains_nothing
from fenics_defo.analysis.inertia import Inertia, body_inertia
from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.search import Search, Solver
from fenics_defo.analysis.spectrum import quadratic_fields, signs
from fenics_defo.analysis.stability import check_unstressed
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.fem.linalg import multiply
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]
# The shift of a loaded body that is free to move, as a part of the first elastic λ's estimate.
_SHIFT = 0.05
# Residuals that inner solves of 1e-11 leave where the stiffness is uneven or nearly incompressible.
_ITERATIVE_RESIDUAL = 1e-4


def linear_modes(
    solid: Solid,
    count: int,
    *,
    displacement: Array | None = None,
    solver: Solver = "davidson",
    keep_rigid: bool = True,
    verify: bool = True,
    residual_tolerance: float | None = None,
    cluster_tolerance: float = 1e-4,
    seed: int = 0,
    phases: Phases | None = None,
) -> Modes:
    """Lowest undamped vibration modes about the rest shape, or about a stable deformed state.

    Solves K φ = ω² M φ with K the tangent stiffness and M the consistent mass; held components are
    eliminated (their eigenvalues lie at infinity). Motions that strain nothing, rigid ones and
    those about hinges, are known from the mesh and left out of the search. Collective on
    ``solid.comm``; the same result on each rank.

    Args:
        solid: body.
        count: number of modes, rigid ones included if they are kept. A cluster of equal frequencies
            is never cut: its last members are returned beyond ``count``.
        displacement: (n, 3) [m] of the state that the body vibrates about (pre-stress); rest if not
            given.
        solver: "davidson": block Davidson with MUMPS's factors; "krylov-schur": SLEPc's
            Krylov-Schur, shift and invert, one vector at a time; "iterative": block Davidson with
            inner solves by conjugate gradients and an algebraic multigrid that knows the rigid
            motions, for bodies whose factors do not fit into memory.
        keep_rigid: keep the rigid modes of a free body, as the first of the list.
        verify: prove by an inertia count of K - σ M above the last mode that none is missing; one
            more factorisation. Not with the iterative solver.
        residual_tolerance: largest accepted relative residual ‖Kφ - ω²Mφ‖ / ‖ω²Mφ‖ of a mode [-];
            if not given, 1e-4 for the iterative solver, else 1e-6, or thirty times the round-off
            of Kφ where that is more (long thin bodies on fine meshes), 1e-2 at most.
        cluster_tolerance: relative distance of frequencies that count as equal [-].
        seed: of the random start vectors.
        phases: stopwatch for "assemble", "factorise", "solve", "count".

    Returns:
        the modes over the nodes in the user's order.

    Raises:
        DefoError: ``count`` or ``solver`` out of range, ``displacement`` of the wrong shape.
        EigenSolveError: modes did not converge, are missing or inaccurate, or the state is not
            stable, or the rest shape not an equilibrium.
        SolverError: the stiffness could not be factorised.
    """
    phases = phases or Phases()
    _check_arguments(solid, displacement, solver, residual_tolerance, cluster_tolerance, seed)
    with ExitStack() as stack:
        with phases("assemble"):
            motions = free_motions(solid, displacement)
            limit = int(np.count_nonzero(~solid.held & solid.nodes.carried[:, None]))
            limit -= 0 if keep_rigid else len(motions)
            if limit == 0:
                raise DefoError(
                    "nothing is left free to move; hold fewer nodes, or keep rigid modes"
                )
            if not (isinstance(count, int | np.integer) and 1 <= count <= limit):
                raise DefoError(
                    f"count must be a whole number from 1 to {limit}, the motions of this body, "
                    f"got {count!r}"
                )
            if displacement is None:
                check_unstressed(solid)
            body = _assemble(stack, solid, displacement, motions)
        search = Search(
            deflation=body.deflation,
            near_kernel=body.fields[:, :6],
            scale=body.scale,
            strainless=len(motions),
            solver=solver,
            count=int(count),
            keep_rigid=keep_rigid,
            cluster_rtol=2.0 * cluster_tolerance,
            seed=seed,
            phases=phases,
        )
        pairs, complete = search.run(verify=verify and solver != "iterative")
        tolerance = residual_tolerance
        if tolerance is None and solver == "iterative":
            tolerance = _ITERATIVE_RESIDUAL
        pairs, residuals = _checked(body, pairs, tolerance, 2.0 * cluster_tolerance)
        modes = _modes(body, pairs, residuals, complete=complete)
    if keep_rigid:
        return modes
    return replace(modes.select(slice(modes.rigid_modes, None)), complete=complete)


def _check_arguments(
    solid: Solid,
    displacement: Array | None,
    solver: str,
    residual_tolerance: float | None,
    cluster_tolerance: float,
    seed: int,
) -> None:
    if solver not in get_args(Solver):
        raise DefoError(f"solver must be one of {', '.join(get_args(Solver))}, got {solver!r}")
    if residual_tolerance is not None and not residual_tolerance > 0.0:
        raise DefoError(f"residual_tolerance must be positive, got {residual_tolerance!r}")
    if not 0.0 <= cluster_tolerance < 0.1:
        raise DefoError(f"cluster_tolerance must be from 0 to 0.1, got {cluster_tolerance!r}")
    if not (isinstance(seed, int | np.integer) and seed >= 0):
        raise DefoError(f"seed must be a whole number from 0, got {seed!r}")
    if displacement is not None:
        shape, given = solid.points.shape, np.asarray(displacement)
        if given.shape != shape:
            raise DefoError(f"displacement must have the shape {shape}, got {given.shape}")
        if not np.isfinite(given).all():
            raise DefoError("displacement must be finite, got NaN or infinity")


@dataclass(frozen=True, slots=True)
class _Body:
    """A body ready for the search.

    Args:
        solid: the body.
        deflation: its matrices and shift, and its strainless motions.
        inertia: its masses.
        node_mass: lumped (n,) [kg].
        scale: about a deformed state, estimate of the first elastic λ, from above [rad²/s²].
        fields: (owned dofs, 30) polynomial displacements, zero at held components, of norm about 1
            in M, or 0.
    """

    solid: Solid
    deflation: Deflation
    inertia: Inertia
    node_mass: Array
    scale: float
    fields: Array


def _assemble(stack: ExitStack, solid: Solid, displacement: Array | None, motions: Array) -> _Body:
    """Assemble a body's matrices, which the stack will destroy, and choose the shift."""
    assembly, rest = solid.assembly, displacement is None
    free = ~assembly.held[: assembly.owned].ravel()
    local = None if rest else solid.nodes.scatter(np.asarray(displacement, np.float64))
    stiffness = assembly.stiffness_matrix(local)
    stack.callback(stiffness.destroy)
    problem = EigenProblem(
        stiffness=stiffness,
        mass=assembly.mass,
        pencil=assembly.pencil(stiffness),
        shift=0.0,
        definite=rest and solid.is_isotropic_at_rest,
        independent=int(solid.comm.allreduce(int(free.sum()))),
        free=free,
    )
    points = solid.points if displacement is None else solid.points + displacement
    node_mass = solid.lumped_mass()
    fields = _polynomials(solid, points, node_mass, problem)
    deflation, scale = deflated(solid, problem, motions), 0.0
    if displacement is not None:
        scale = _first_elastic(problem, fields, len(motions))
        if not strains_nothing(deflation, solid, displacement):
            # Loads that keep their direction give the motions a stiffness, as to a pendulum.
            shifted = replace(problem, shift=-_SHIFT * scale)
            deflation = deflated(solid, shifted, motions[:0])
    return _Body(solid, deflation, body_inertia(solid), node_mass, scale, fields)


def _polynomials(solid: Solid, points: Array, node_mass: Array, problem: EigenProblem) -> Array:
    """Quadratic displacement fields (owned dofs, 30) over the box of the points, scaled."""
    owned, low, high = solid.assembly.owned, points.min(axis=0), points.max(axis=0)
    place = (points - 0.5 * (low + high)) / (0.5 * float(np.max(high - low)))
    own = quadratic_fields(solid.nodes.scatter(place)[:owned]).reshape(30, -1).T
    fields = np.asfortranarray(own * problem.free[:, None])
    masses = np.repeat(solid.nodes.scatter(node_mass)[:owned], 3)
    norms = problem.norms(fields * np.sqrt(masses)[:, None])
    fields /= np.where(norms > 0.0, norms, 1.0)
    return fields


def _first_elastic(problem: EigenProblem, fields: Array, rigid: int) -> float:
    """Rayleigh-Ritz estimate, from above, of the first λ that is no rigid motion's."""
    stiffness = problem.products(fields, multiply(problem.stiffness, fields))
    mass = problem.products(fields, problem.mass.multiply(fields))
    weight = np.sqrt(np.maximum(np.diag(mass), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(mass / np.outer(weight, weight))
    kept = values > 1e-10
    turn = vectors[:, kept] / weight[:, None] / np.sqrt(values[kept])
    ritz = np.linalg.eigvalsh(turn.T @ stiffness @ turn)
    return float(ritz[min(rigid, len(ritz) - 1)])


def _modes(body: _Body, pairs: Pairs, residuals: Array, *, complete: bool) -> Modes:
    """The user's record of pairs that have stood the checks."""
    solid, problem, inertia = body.solid, body.deflation.problem, body.inertia
    local = pairs.vectors.reshape(-1, 3, len(pairs.values))
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
        node_mass=body.node_mass,
        residuals=residuals,
        rigid_modes=int(np.count_nonzero(pairs.values == 0.0)),
        complete=complete,
        participation=problem.products(pairs.vectors, inertia.momenta) * sign[:, None],
        total_mass=inertia.total_mass,
        centre=inertia.centre,
        inertia=inertia.moments,
    )


def _checked(
    body: _Body, pairs: Pairs, tolerance: float | None, cluster_rtol: float
) -> tuple[Pairs, Array]:
    problem, fields = body.deflation.problem, body.fields
    elastic = pairs.values[pairs.values > 0.0]
    return checked_pairs(
        problem,
        pairs,
        fields=fields,
        floor=float(elastic[0])
        if elastic.size
        else _first_elastic(problem, fields, pairs.converged),
        tolerance=tolerance,
        cluster_rtol=cluster_rtol,
    )
