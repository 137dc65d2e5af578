"""What to say of a state about which there are no vibrations."""

import numpy as np

from fenics_defo.errors import EigenSolveError
from fenics_defo.fem import Solid

# Largest internal force at rest, relative to that of strains of order one.
_BALANCED = 1e-8


def check_unstressed(solid: Solid) -> None:
    """Refuse a body whose energy pushes its free nodes at rest; collective.

    Raises:
        EigenSolveError: the rest shape is not an equilibrium.
    """
    if solid.is_isotropic_at_rest:
        return
    force = np.where(solid.held, 0.0, solid.internal_force())
    stiffness = solid.assembly.stiffness_matrix()
    diagonal = stiffness.getDiagonal()
    stiffest = float(np.abs(diagonal.array).max(initial=0.0))
    diagonal.destroy()
    stiffness.destroy()
    size = float(np.ptp(solid.points, axis=0).max())
    scale = max(solid.comm.allgather(stiffest)) * size
    largest = float(np.abs(force).max())
    if not largest <= _BALANCED * scale:
        raise EigenSolveError(
            "the rest shape is not an equilibrium: the energy is stressed there, and pushes a free "
            f"node with {largest:.3g} N; add a term to the energy that cancels the stress at "
            "F = I, or give the displacement of an equilibrium"
        )


def not_stable(negative: int) -> EigenSolveError:
    """The error for a tangent with so many negative eigenvalues."""
    plural = "s" if negative != 1 else ""
    return EigenSolveError(
        f"this is not a stable state: the tangent has {negative} negative "
        f"eigenvalue{plural}; modes exist about stable equilibria only. "
        "Lower the load below buckling, converge the equilibrium, or check the energy"
    )
