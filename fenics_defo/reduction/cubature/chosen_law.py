"""The law of the points that were chosen, and what it keeps of the stiffness at rest."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.candidates import LawPoints
from fenics_defo.runtime.forces import CubatureForce

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def assembled(
    groups: tuple[LawPoints, ...], numbers: IntArray, weights: Array, comm: MPI.Comm
) -> CubatureForce:
    """The law of some candidates, gathered from the ranks that have them; collective.

    Args:
        groups: this rank's candidates.
        numbers: of the chosen ones (p,), ascending.
        weights: theirs (p,) [m³].
        comm: communicator.
    """
    parts = []
    for points in groups:
        own = np.isin(points.numbers, numbers)
        found = points.numbers[own]
        shares = weights[np.searchsorted(numbers, found)]
        local = found, shares, points.gradients[own], points.parameters[:, own].T
        everywhere = [np.concatenate(x) for x in zip(*comm.allgather(local), strict=True)]
        order = np.argsort(everywhere[0])
        if len(order):
            parts.append((points.law, *(column[order] for column in everywhere[1:])))
    laws, each, gradients, parameters = zip(*parts, strict=True)
    return CubatureForce(
        np.concatenate(each),
        np.concatenate(gradients),
        laws,
        tuple(len(column) for column in each),
        tuple(np.ascontiguousarray(values.T) for values in parameters),
    )


def corrected(force: CubatureForce, lack: Array) -> CubatureForce:
    """The law with what it lacks of a stiffness (r, r) added for good."""
    return CubatureForce(
        force.weights,
        force.gradients,
        force.laws,
        force.counts,
        force.parameters,
        0.5 * (lack + lack.T),
    )


def frequency_error(exact: Array, lack: Array) -> float:
    """Largest |ω̂ / ω − 1| over all directions of the basis: of Rayleigh's quotients of K̂ in K."""
    values, vectors = np.linalg.eigh(0.5 * (exact + exact.T))
    scaled = vectors / np.sqrt(values)
    relative = np.linalg.eigvalsh(scaled.T @ (0.5 * (lack + lack.T)) @ scaled)
    ratios = np.sqrt(np.maximum(1.0 - relative, 0.0))
    return float(np.abs(ratios - 1.0).max())
