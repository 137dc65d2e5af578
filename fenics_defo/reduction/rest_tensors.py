"""Derivatives of a strain energy at rest up to the fourth, by UFL's differentiation."""

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.energy import Material
from fenics_defo.energy.evaluation import Program

Array = NDArray[np.float64]

_ORDER = 4
_ENTRIES = [np.array(list(combinations_with_replacement(range(9), k))) for k in range(_ORDER + 1)]
#: The pairs a ≤ b of the nine components of a gradient, 3 i + j of [i, j], in row-major order.
PAIRS: tuple[NDArray[np.intp], NDArray[np.intp]] = np.triu_indices(9)


@dataclass(frozen=True, slots=True)
class RestTensors:
    """Derivatives of ψ by the nine components of F at F = I, for m sets of constants.

    Args:
        first: (m, 9) [Pa], the stress.
        second: (m, 9, 9) [Pa].
        third: (m, 45, 9) [Pa], a row a pair of `PAIRS`.
        fourth: (m, 45, 45) [Pa].
    """

    first: Array
    second: Array
    third: Array
    fourth: Array


class RestDerivatives:
    """The derivatives of one energy function, for any constants.

    ψ(I + Σ t_k H_k) is differentiated once by each of t_1, t_2, ..., and evaluated at t = 0 with
    single components for the H_k.

    Args:
        material: any material of that energy function.

    Raises:
        MaterialError: the energy is no scalar, or holds what has no value at one point.
    """

    def __init__(self, material: Material) -> None:
        constants = {name: ufl.variable(ufl.as_ufl(1.0)) for name in material.parameters}
        steps = [ufl.variable(ufl.as_ufl(0.0)) for _ in range(_ORDER)]
        along = [ufl.variable(ufl.Identity(3)) for _ in range(_ORDER)]
        moved = ufl.Identity(3) + sum(t * H for t, H in zip(steps, along, strict=True))
        derivative = material.strain_energy(ufl.variable(moved), constants)
        self._programs = []
        for order in range(1, _ORDER + 1):
            derivative = ufl.diff(derivative, steps[order - 1])
            symbols = [*along[:order], *steps, *constants.values()]
            self._programs.append(Program([derivative], symbols))

    def __call__(self, constants: Array) -> RestTensors:
        """The tensors for m sets of constants (m, number of them), in the material's order.

        They are NaN or infinite where the energy has no such derivative.
        """
        first, second, third, fourth = (
            _unfolded(self._unique(order, constants), order) for order in range(1, _ORDER + 1)
        )
        a, b = PAIRS
        return RestTensors(first, second, third[:, a, b], fourth[:, a, b][:, :, a, b])

    def _unique(self, order: int, constants: Array) -> Array:
        """Entries (m, e) of ascending indices."""
        entries, unit = _ENTRIES[order], np.eye(9).reshape(9, 3, 3)
        count = len(constants)
        along = [np.tile(unit[column], (count, 1, 1)) for column in entries.T]
        values = [np.repeat(column, len(entries)) for column in constants.T]
        (answer,) = self._programs[order - 1](*along, *[0.0] * _ORDER, *values)
        return np.broadcast_to(answer, (count * len(entries),)).reshape(count, -1)


def _unfolded(unique: Array, order: int) -> Array:
    """The symmetric tensors (m, 9, ..., 9) of unique entries (m, e)."""
    place = np.zeros((9,) * order, np.intp)
    place[tuple(_ENTRIES[order].T)] = np.arange(unique.shape[1])
    ascending = np.sort(np.indices(place.shape), axis=0)
    return unique[:, place[tuple(ascending)]]
