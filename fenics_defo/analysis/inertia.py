"""Mass, centre and moments of inertia of a body, and the momenta of its rigid motions."""

from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.rigid import rigid_motions
from fenics_defo.fem import Solid

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Inertia:
    """How a body resists its rigid motions r: x, y, z, and rotations about its centre of mass.

    Args:
        total_mass: [kg].
        centre: (3,) centre of mass [m].
        moments: (6,) rᵀ M r: mass thrice [kg], moments of inertia about the axes [kg m²].
        momenta: (owned dofs, 6) M r over this rank's dofs, held ones included.
    """

    total_mass: float
    centre: Array
    moments: Array
    momenta: Array


def body_inertia(solid: Solid) -> Inertia:
    """Integrate a body's inertia with its consistent mass; collective."""
    mass, comm = solid.assembly.mass, solid.comm
    points = solid.nodes.scatter(solid.points)[: solid.assembly.owned]
    share = mass.apply(np.ones((len(points), 1)))[:, 0]
    sums = np.append(share @ points, share.sum())
    comm.Allreduce(MPI.IN_PLACE, sums, op=MPI.SUM)
    total, centre = float(sums[3]), sums[:3] / sums[3]
    motions = rigid_motions(points, centre).transpose(1, 2, 0)
    momenta = mass.apply(motions.reshape(len(points), 18)).reshape(-1, 6)
    moments = np.einsum("ij,ij->j", momenta, motions.reshape(-1, 6))
    comm.Allreduce(MPI.IN_PLACE, moments, op=MPI.SUM)
    return Inertia(total, centre, moments, momenta)
