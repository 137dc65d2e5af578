"""What is read off a motion: energies, momenta, reactions."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.instant import Instant
from fenics_defo.analysis.states import Energies, State
from fenics_defo.analysis.system import System
from fenics_defo.analysis.work import Work
from fenics_defo.errors import LoadError

Array = NDArray[np.float64]


def energies_of(system: System, now: Instant, work: Work) -> Energies:
    """Energies at an instant; collective."""
    return Energies(
        kinetic=0.5 * system.product(now.velocity, system.mass.apply(now.velocity)),
        strain=system.strain_energy(now.displacement),
        external=work.external,
        dissipated=work.dissipated,
    )


def momenta_of(system: System, now: Instant) -> tuple[Array, Array]:
    """Momentum (3,) and angular momentum (3,) about the origin; collective."""
    nodes = system.solid.nodes
    momenta = system.mass.apply(now.velocity)
    places = nodes.points[nodes.rows[: nodes.owned]] + now.displacement
    own = np.array([momenta.sum(axis=0), np.cross(places, momenta).sum(axis=0)])
    linear, angular = system.comm.allreduce(own)
    return linear, angular


def reactions_of(system: System, now: Instant) -> Array:
    """M a + C v + f - g (n, 3) [N] where not free, zero elsewhere; collective."""
    forces = system.forces(now)
    balance = system.mass.apply(now.acceleration) + forces.damping
    balance += forces.internal - forces.external
    return system.solid.nodes.gather_own(np.where(system.free, 0.0, balance))


def fields_of(state: State, size: int) -> list[Array]:
    """Displacement, velocity and acceleration (n, 3) of a state of a body of n nodes.

    Raises:
        LoadError: they are of another shape, or not finite.
    """
    fields = []
    for name in ("displacement", "velocity", "acceleration"):
        values = np.asarray(getattr(state, name), dtype=np.float64)
        if values.shape != (size, 3) or not np.isfinite(values).all():
            raise LoadError(
                f"the {name} of a state of this body must be finite numbers of the shape "
                f"({size}, 3), got an array of the shape {values.shape}"
            )
        fields.append(values)
    return fields
