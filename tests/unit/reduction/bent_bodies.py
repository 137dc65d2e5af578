"""A small bent beam for the tests of bases, its modes by SciPy, and its equilibria by Newton."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from fenics_defo.analysis import linear_modes
from fenics_defo.energy import NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid, build_mesh
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SOFT = {"young": 1.0e5, "poisson": 0.3, "density": 1000.0}
STVK, NEO = StVenantKirchhoff(**SOFT), NeoHookean(**SOFT)
LENGTH, WIDTH, HEIGHT = 2.0, 0.5, 0.35

_SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
_HEXAHEDRON = np.array([(x, y, z) for z in (0, 1) for x, y in _SQUARE])  # VTK's order
_TETRAHEDRA = np.array(
    [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
)


def beam_arrays(kind: str, cells: tuple[int, int, int] = (4, 1, 1)) -> tuple[Array, Ints]:
    """Points and cells of a sector of a ring, one radian about an axis along y."""
    counts = np.array(cells) + 1
    ticks = [np.linspace(0.0, 1.0, n) for n in counts]
    unit = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    first = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1)
    rows = np.ravel_multi_index(
        tuple(np.moveaxis(first.reshape(-1, 1, 3) + _HEXAHEDRON, -1, 0)), tuple(counts)
    )
    if kind == "tetrahedron":
        rows = rows[:, _TETRAHEDRA].reshape(-1, 4)
    angle, radius = unit[:, 0], LENGTH + HEIGHT * unit[:, 2]
    points = np.stack([radius * np.sin(angle), WIDTH * unit[:, 1], radius * np.cos(angle)], axis=1)
    return points, rows


def beam(
    material: Any = STVK, *, kind: str = "hexahedron", held: bool = True, **options: Any
) -> Solid:
    cells = options.pop("cells", (4, 1, 1))
    mesh = build_mesh(*beam_arrays(kind, cells), kind=kind)
    return Solid(mesh, material, fixed=["x<1e-9"] if held else [], **options)


@cache
def usual(*, held: bool = True) -> tuple[Solid, Modes]:
    """A body of St. Venant-Kirchhoff's law and four of its elastic modes."""
    solid = beam(held=held)
    return solid, linear_modes(solid, 4 if held else 10)


def rigid(modes: Modes) -> Array:
    return modes.shapes[: modes.rigid_modes].reshape(modes.rigid_modes, modes.points.size)


def elastic(modes: Modes) -> Array:
    return modes.shapes[modes.rigid_modes :]


def equilibrium(solid: Solid, load: Array, start: Array, kernel: Array) -> Array:
    """Displacement (n, 3) at which f(u) = load but for the inertia of rigid motions.

    Newton's method on the dense system that keeps rows of ``kernel`` (k, 3n) out of u - start.
    """
    free = np.flatnonzero(~solid.held.ravel())
    momenta = (solid.mass() @ kernel.T)[free]
    size, count = len(free), len(kernel)
    u, multipliers = start.ravel().copy(), np.zeros(count)
    system = np.zeros((size + count, size + count))
    system[:size, size:] = momenta
    system[size:, :size] = momenta.T
    for _ in range(30):
        state = u.reshape(-1, 3)
        system[:size, :size] = solid.tangent(state).toarray()[np.ix_(free, free)]
        rest = (solid.internal_force(state) - load).ravel()[free] + momenta @ multipliers
        gap = momenta.T @ (u - start.ravel())[free]
        step = linalg.solve(system, -np.append(rest, gap))
        u[free] += step[:size]
        multipliers += step[size:]
        if np.abs(step[:size]).max() <= 1e-13 * np.abs(u).max():
            return u.reshape(-1, 3)
    raise AssertionError("Newton's method did not converge")


def curved_response(
    solid: Solid, modes: Modes, pair: tuple[int, int], size: float, state: Array
) -> Array:
    """∂²u/∂p_i∂p_j (n, 3) by differences over ``size`` of the answer to f(state) + M Ψ Λ p."""
    chosen, values = elastic(modes), modes.omega[modes.rigid_modes :] ** 2
    dead = np.zeros(solid.points.shape) if not state.any() else solid.internal_force(state)

    def answer(p: Array) -> Array:
        push = np.tensordot(p * values, chosen, 1)
        load = dead + (solid.mass() @ push.ravel()).reshape(-1, 3)
        return equilibrium(solid, load, state, rigid(modes))

    one, other = size * np.eye(len(chosen))[list(pair)]
    if pair[0] == pair[1]:
        return (answer(one) - 2.0 * state + answer(-one)) / size**2
    mixed = answer(one + other) - answer(one - other) - answer(other - one) + answer(-one - other)
    return mixed / (4.0 * size**2)


def spans(solid: Solid, fields: Array, shapes: Array) -> float:
    """Largest part of a field (s, n, 3) that shapes (r, n, 3) cannot make, in the norm of M."""
    mass = solid.mass()
    U, S = (f.reshape(len(f), -1).T for f in (shapes, fields))
    rest = S - U @ np.linalg.solve(U.T @ (mass @ U), U.T @ (mass @ S))
    size = np.sqrt(np.diag(S.T @ (mass @ S)))
    return float((np.sqrt(np.maximum(np.diag(rest.T @ (mass @ rest)), 0.0)) / size).max())
