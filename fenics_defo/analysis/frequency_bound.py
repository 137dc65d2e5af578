"""The largest frequency of a body, which limits the steps of explicit methods."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.inertia_operators import LumpedMass
from fenics_defo.errors import SolverError
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import MPI

Array = NDArray[np.float64]

_ITERATIONS = 200
_TOLERANCE = 1e-4


def largest_frequency(solid: Solid, displacement: Array, free: NDArray[np.bool_]) -> float:
    """Largest ω [rad/s] of K(u) φ = ω² M φ with the lumped mass; collective.

    Lanczos' method on M^-½ K M^-½ with full orthogonalisation. The largest Ritz value comes from
    below; its error bound is added to it.

    Args:
        solid: body.
        displacement: (d, 3) [m] of this rank's nodes, ghosts included.
        free: (owned nodes, 3) components that are not held or prescribed.

    Returns:
        ω, from above by 5e-5 of it at most; 0 where nothing is free or stiff.

    Raises:
        SolverError: the stiffness holds NaN or infinity.
    """
    assembly, comm = solid.assembly, solid.comm
    weight = np.where(free, 1.0 / np.sqrt(LumpedMass(assembly).nodes), 0.0).ravel()
    matrix = assembly.empty_matrix()
    assembly.fill_tangent(matrix, displacement)
    given, product = matrix.createVecs()

    def operate(vector: Array) -> Array:
        given.array[:] = weight * vector
        matrix.mult(given, product)
        return weight * product.array

    try:
        value = _largest(operate, _start(solid, free), comm)
    finally:
        for thing in (matrix, given, product):
            thing.destroy()
    if not np.isfinite(value):
        raise SolverError("the stiffness holds NaN or infinity: it has no largest frequency")
    return float(np.sqrt(max(value, 0.0)))


def _start(solid: Solid, free: NDArray[np.bool_]) -> Array:
    """Random numbers that do not depend on how the body is spread over ranks."""
    noise = np.random.default_rng(0).standard_normal((solid.nodes.size, 3))
    return np.where(free, solid.nodes.scatter(noise)[: len(free)], 0.0).ravel()


def _largest(operate: Callable[[Array], Array], start: Array, comm: MPI.Comm) -> float:
    """Largest eigenvalue, its error bound added."""

    def dots(basis: list[Array], vector: Array) -> Array:
        return np.asarray(comm.allreduce(np.array([np.vdot(other, vector) for other in basis])))

    norm = float(np.sqrt(dots([start], start)[0]))
    if not norm > 0.0:
        return 0.0
    basis, diagonal, beside = [start / norm], list[float](), list[float]()
    for _ in range(_ITERATIONS):
        image = operate(basis[-1])
        for turn in range(2):  # twice is enough
            parts = dots(basis, image)
            for part, other in zip(parts, basis, strict=True):
                image -= part * other
            if turn == 0:
                diagonal.append(float(parts[-1]))
        rest = float(np.sqrt(dots([image], image)[0]))
        if not np.isfinite(rest):
            return rest
        table = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        values, vectors = np.linalg.eigh(table)
        bound = rest * abs(float(vectors[-1, -1]))
        if bound <= _TOLERANCE * abs(values[-1]) or rest == 0.0:
            return float(values[-1]) + bound
        beside.append(rest)
        basis.append(image / rest)
    return float(values[-1]) + bound
