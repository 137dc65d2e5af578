"""Small bodies in motion for comparing integrators with theory."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from bodies import Array, box
from scipy.linalg import eigh

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    ImplicitNewmark,
    Initial,
    Integrator,
    Simulation,
    State,
    SymplecticEuler,
    simulate,
)
from fenics_defo.energy import LinearElastic, Material
from fenics_defo.fem import Solid

INTEGRATORS: dict[str, Integrator] = {
    "newmark": ImplicitNewmark(),
    "backward-euler": BackwardEuler(),
    "central-differences": CentralDifferences(),
    "symplectic-euler": SymplecticEuler(),
}
ORDERS = {
    "newmark": 2.0,
    "backward-euler": 1.0,
    "central-differences": 2.0,
    "symplectic-euler": 1.0,
}
EXPLICIT = ("central-differences", "symplectic-euler")

# Soft enough that a second is long.
CONSTANTS = {"young": 2.0e4, "poisson": 0.3, "density": 1000.0}


def bar(law: type = LinearElastic, *, fixed: tuple[str, ...] = ("x==0",)) -> Solid:
    """A short thick bar of 4 hexahedra, whose frequencies lie close together."""
    material: Material = law(**CONSTANTS)
    return Solid(box("hexahedron", (4, 1, 1), (1.0, 0.3, 0.25)), material, fixed=list(fixed))


@dataclass(frozen=True)
class OneMode:
    """A mode of the matrices that an integrator works with.

    Args:
        omega: [rad/s].
        shape: (n, 3), of modal mass one.
        covector: (n, 3); its product with a displacement is the mode's coordinate.
    """

    omega: float
    shape: Array
    covector: Array

    def coordinate(self, field: Array) -> float:
        """Of a displacement or a velocity (n, 3)."""
        return float((self.covector * field).sum())


def one_mode(solid: Solid, number: int, *, lumped: bool) -> OneMode:
    """Mode ``number`` (from 0) of K and the consistent or the lumped mass, by a dense solver."""
    free = ~solid.held.ravel()
    stiffness = solid.tangent().toarray()[np.ix_(free, free)]
    full = np.diag(np.repeat(solid.lumped_mass(), 3)) if lumped else solid.mass().toarray()
    mass = full[np.ix_(free, free)]
    squares, shapes = eigh(stiffness, mass)
    shape, covector = np.zeros((2, free.size))
    shape[free] = shapes[:, number]
    covector[free] = mass @ shapes[:, number]
    size = solid.points.shape
    return OneMode(float(np.sqrt(squares[number])), shape.reshape(size), covector.reshape(size))


def states(
    solid: Solid, integrator: Integrator, *, step: float, count: int, **options: Any
) -> list[State]:
    """The states of ``count`` steps, the start first."""
    found: list[State] = []

    def observe(simulation: Simulation) -> None:
        found.append(simulation.state)

    simulate(
        solid,
        options.pop("loads", []),
        integrator,
        step=step,
        duration=count * step,
        observe=observe,
        energies_every=0,
        **options,
    )
    assert len(found) == count + 1
    return found


def modal_motion(
    method: Integrator,
    *,
    number: int,
    step: float,
    count: int,
    damping: tuple[float, float] = (0.0, 0.0),
    velocity: float = 0.0,
) -> tuple[OneMode, Array, Array]:
    """A mode, and its coordinate and rate (count + 1,) when it starts alone, with coordinate 1."""
    solid = bar()
    mode = one_mode(solid, number, lumped=method.explicit)
    found = states(
        solid,
        method,
        step=step,
        count=count,
        damping=damping,
        initial=Initial(displacement=mode.shape, velocity=velocity * mode.shape),
    )
    coordinate = np.array([mode.coordinate(state.displacement) for state in found])
    rate = np.array([mode.coordinate(state.velocity) for state in found])
    # The mode stays alone: what it does not explain is round-off.
    last = found[-1].displacement
    scale = np.abs(coordinate).max() * np.abs(mode.shape).max()
    assert np.abs(last - coordinate[-1] * mode.shape).max() < 1e-8 * scale
    return mode, coordinate, rate


def halving(error: Callable[[int], float], counts: tuple[int, ...]) -> Array:
    """Observed orders of an error as the number of steps is doubled along ``counts``."""
    errors = np.array([error(count) for count in counts])
    return np.log2(errors[:-1] / errors[1:])
