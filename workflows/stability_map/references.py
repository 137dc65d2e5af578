"""Independent references: modes by LAPACK, the scalar oscillator, a fine Runge-Kutta run."""

from collections.abc import Callable
from dataclasses import dataclass

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import cho_factor, cho_solve, eigh

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Vibrations about rest, of the discrete body, by LAPACK on its full matrices.

    Args:
        omega: (k,) [rad/s], ascending.
        shapes: (k, n, 3), the largest displacement of a node 1.
        mass: (f, f) of the free components [kg].
    """

    omega: Array
    shapes: Array
    mass: Array


def spectrum(solid: fem.Solid, *, lumped: bool) -> Spectrum:
    """All modes of a small body, with the consistent mass or the lumped one."""
    free = np.flatnonzero(~solid.held.ravel())
    stiffness = solid.tangent().toarray()[np.ix_(free, free)]
    if lumped:
        mass = np.diag(np.repeat(solid.lumped_mass(), 3)[free])
    else:
        mass = solid.mass().toarray()[np.ix_(free, free)]
    values, vectors = eigh(stiffness, mass)
    shapes = np.zeros((len(values), solid.held.size))
    shapes[:, free] = vectors.T
    shapes = shapes.reshape(-1, *solid.held.shape)
    shapes /= np.linalg.norm(shapes, axis=2).max(axis=1)[:, None, None]
    return Spectrum(np.sqrt(np.maximum(values, 0.0)), shapes, mass)


def oscillator(integrator: analysis.Integrator, omega: float, step: float, count: int) -> Array:
    """What a method makes of u'' = -ω² u from u = 0, v = ω, (count + 1,).

    The methods' textbook rules for one unknown; nothing of the package is used.
    """
    u, v, a = 0.0, omega, 0.0
    path = [u]
    square = omega**2
    for _ in range(count):
        match integrator:
            case analysis.ImplicitNewmark(beta=beta, gamma=gamma):
                guess = u + step * v + step**2 * (0.5 - beta) * a
                after = -square * guess / (1.0 + beta * step**2 * square)
                u = guess + beta * step**2 * after
                v += step * ((1.0 - gamma) * a + gamma * after)
                a = after
            case analysis.BackwardEuler():
                u = (u + step * v) / (1.0 + step**2 * square)
                v = v - step * square * u
            case analysis.CentralDifferences():
                v -= 0.5 * step * square * u
                u += step * v
                v -= 0.5 * step * square * u
            case analysis.SymplecticEuler():
                v -= step * square * u
                u += step * v
        path.append(u)
    return np.array(path)


def fine_motion(
    solid: fem.Solid, velocity: Array, until: float, *, lumped: bool
) -> Callable[[Array], Array]:
    """Motion from rest with a velocity (n, 3), by Dormand and Prince's method of order 8.

    The time integration is SciPy's; only the forces f(u) are the package's.

    Returns:
        displacements (t, n, 3) at times (t,) not after ``until``.
    """
    free = ~solid.held.ravel()
    inverse = _inverse_mass(solid, free, lumped=lumped)
    count = int(free.sum())

    def rate(_: float, state: Array) -> Array:
        full = np.zeros(solid.held.size)
        full[free] = state[:count]
        force = solid.internal_force(full.reshape(-1, 3)).ravel()[free]
        return np.concatenate([state[count:], -inverse(force)])

    begin = np.concatenate([np.zeros(count), velocity.ravel()[free]])
    scale = float(np.abs(solid.points).max())
    found = solve_ivp(
        rate,
        (0.0, until),
        begin,
        method="DOP853",
        dense_output=True,
        rtol=1e-8,
        atol=1e-9 * scale,
    )
    assert found.success, found.message

    def at(times: Array) -> Array:
        full = np.zeros((len(times), solid.held.size))
        full[:, free] = found.sol(times)[:count].T
        return full.reshape(len(times), -1, 3)

    return at


def _inverse_mass(
    solid: fem.Solid, free: NDArray[np.bool_], *, lumped: bool
) -> Callable[[Array], Array]:
    if lumped:
        nodes = np.repeat(solid.lumped_mass(), 3)[free]
        return lambda force: force / nodes
    rows = np.flatnonzero(free)
    factor = cho_factor(solid.mass().toarray()[np.ix_(rows, rows)])
    return lambda force: cho_solve(factor, force)
