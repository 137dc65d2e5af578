"""What to say of a state about which there are no vibrations."""

from fenics_defo.errors import EigenSolveError


def not_stable(negative: int) -> EigenSolveError:
    """The error for a tangent with so many negative eigenvalues."""
    plural = "s" if negative != 1 else ""
    return EigenSolveError(
        f"the given displacement is not a stable state: the tangent has {negative} negative "
        f"eigenvalue{plural}; modes exist about stable equilibria only. "
        "Lower the load below buckling, or converge the equilibrium"
    )
