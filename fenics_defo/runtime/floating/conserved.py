"""What a flying body keeps when nothing acts on it: energy and momenta."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.floating.inertia import Inertia
from fenics_defo.runtime.floating.products import times
from fenics_defo.runtime.floating.rotations import cross
from fenics_defo.runtime.floating.state import FloatingState

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FloatingEnergies:
    """Energies of a floating body [J]; with the leading axes of a batch.

    Args:
        kinetic: of the whole motion.
        strain: elastic.
    """

    kinetic: Array
    strain: Array


def kinetic_energy(state: FloatingState, inertia: Inertia, *, mass: float) -> Array:
    """M |c'|² / 2 + w . I w / 2 + w . A q' + q' . M q' / 2 (...) [J]."""
    at = inertia.at(state.q)
    turning = 0.5 * times(at.inertia, state.spin) + times(at.coupling, state.v)
    energy = 0.5 * mass * (state.velocity**2).sum(axis=-1) + (state.spin * turning).sum(axis=-1)
    return np.asarray(energy + 0.5 * (state.v * times(inertia.mass, state.v)).sum(axis=-1))


def momenta(state: FloatingState, inertia: Inertia, *, mass: float) -> tuple[Array, Array]:
    """M c' (..., 3) [kg m/s], and c x m c' + R (I w + A q') (..., 3) [kg m²/s]."""
    at = inertia.at(state.q)
    inside = times(at.inertia, state.spin) + times(at.coupling, state.v)
    linear = mass * state.velocity
    return linear, cross(state.position, linear) + times(state.rotation, inside)
