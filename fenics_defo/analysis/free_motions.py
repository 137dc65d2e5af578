"""What a body can do without strain, left out of its eigenvalue problem or of its answers."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.deflation import Deflation, orthonormal_in_mass
from fenics_defo.analysis.eigenpairs import EigenProblem
from fenics_defo.analysis.rigid import strainless_motions, supports
from fenics_defo.fem import Solid
from fenics_defo.fem.linalg import multiply

Array = NDArray[np.float64]


def free_motions(solid: Solid, displacement: Array | None = None) -> Array:
    """Motions (k, n, 3) without stiffness at rest; about a deformed state, which may have some."""
    points = solid.points if displacement is None else solid.points + displacement
    corners = 4 if solid.nodes.cell_type.startswith("tetra") else 8
    return strainless_motions(points, solid.cells, corners, solid.held)


def deflated(solid: Solid, problem: EigenProblem, motions: Array) -> Deflation:
    """The problem with motions (k, n, 3) left out of it; collective."""
    owned, rows = solid.assembly.owned, len(problem.free)
    local = np.zeros((rows, len(motions)), order="F")
    for column, motion in zip(local.T, motions, strict=True):
        column[:] = solid.nodes.scatter(motion)[:owned].ravel()
    springs = supports(motions, ~solid.held & solid.nodes.carried[:, None])
    held_by = solid.nodes.scatter(springs.astype(np.float64))[:owned].ravel() > 0.0
    return Deflation(problem, *orthonormal_in_mass(problem, local), held_by)


def strains_nothing(deflation: Deflation, solid: Solid, displacement: Array) -> bool:
    """Whether the motions are without stiffness but for round-off, that of F = I + ∇u included."""
    problem, size = deflation.problem, float(np.ptp(solid.points, axis=0).max())
    cell = size / len(solid.cells) ** (1.0 / 3.0)
    digits = 1.0 + (size + float(np.abs(displacement).max())) / cell
    diagonal = problem.stiffness.getDiagonal()
    terms = problem.norms(diagonal.array[:, None] * deflation.motions)
    diagonal.destroy()
    forces = problem.norms(multiply(problem.stiffness, deflation.motions))
    return bool((forces <= 100.0 * digits * np.finfo(float).eps * terms).all())
