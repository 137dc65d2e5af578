"""Static modal derivatives: how a body's answer to modal loads bends away from its modes.

Under the load g = M Ψ Λ p, with Ψ the modes, Λ their λ = ω², p (k,) numbers, the equilibrium
f(u) = g is

    u(p) = Σ p_i ψ_i + ½ Σ p_i p_j Φ_ij + O(p³),    K Φ_ij = -(H : ψ_j) ψ_i,

with K the tangent and H its derivative, both in the state about which the body vibrates. They tell
the displacements that large deformations along the modes need besides. Sources: Barbič and James,
Real-time subspace integration for St. Venant-Kirchhoff deformable models, ACM Transactions on
Graphics 24(3), 2005, section 4; Idelsohn and Cardona, A reduction method for nonlinear structural
dynamic analysis, Computer Methods in Applied Mechanics and Engineering 49, 1985, whose dynamic
derivatives these are without the terms of inertia.
"""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.phases import Phases
from fenics_defo.analysis.static_response import StaticResponse
from fenics_defo.fem import Solid
from fenics_defo.reduction.body_fields import (
    checked_state,
    elastic_modes,
    gathered,
    own_columns,
)
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]

# Loads that are solved for at once: MUMPS gains little from more.
_BLOCK = 64


def modal_derivatives(
    solid: Solid,
    modes: Modes,
    *,
    displacement: Array | None = None,
    phases: Phases | None = None,
) -> Array:
    """Static modal derivatives Φ_ij of all pairs of modes, K Φ_ij = -(H : ψ_j) ψ_i.

    Rigid modes are left out: of a free body k counts the others, the loads are balanced by rigid
    accelerations, and the answers hold no rigid motion. For any law and order of the displacements:
    H by UFL's differentiation, or by differences of the exact tangent of laws that are evaluated at
    points and of springs. Collective; the same result on each rank.

    Args:
        solid: body.
        modes: k of its modes, and rigid ones in front if it is free.
        displacement: (n, 3) [m] of the equilibrium that the modes are about; rest if not given.
        phases: stopwatch for "assemble", "factorise", "multiply", "solve", "gather".

    Returns:
        (k(k + 1)/2, n, 3) [kg^-1 m^-1], pair (i, j), i ≤ j, in row-major order: (0, 0), (0, 1), ...

    Raises:
        DefoError: the modes are not this body's, or ``displacement`` does not fit it.
        EigenSolveError: the state is not a stable equilibrium.
        SolverError: the tangent is singular, or memory ran out.
    """
    phases, displacement = phases or Phases(), checked_state(solid, displacement)
    _, shapes = elastic_modes(solid, modes)
    count = len(shapes)
    found = np.zeros((count * (count + 1) // 2, solid.nodes.size, 3))
    if solid.is_linear:
        return found
    columns, loads, pairs = own_columns(solid, shapes), [], []
    with StaticResponse(solid, displacement, phases=phases) as response:
        for j in range(count):
            direction = solid.nodes.scatter(shapes[j])
            loads.append(-response.curvature(direction, columns[:, : j + 1]))
            pairs += [_place(i, j, count) for i in range(j + 1)]
            if len(pairs) >= _BLOCK or j == count - 1:
                answers = response.solve(np.hstack(loads))
                with phases("gather"):
                    found[pairs] = gathered(solid, answers)
                loads, pairs = [], []
    return found


def _place(i: int, j: int, count: int) -> int:
    """Number of the pair i ≤ j in row-major order."""
    return i * count - i * (i - 1) // 2 + j - i
