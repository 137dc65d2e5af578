"""Isotropic energies as functions of the principal stretches."""

from dataclasses import dataclass

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.energy.evaluation import Program
from fenics_defo.energy.material import IsotropicMaterial
from fenics_defo.runtime.laws.stretches import of_stretches

type Array = NDArray[np.float64]

_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True, slots=True)
class StretchEnergy:
    """ψ(s1, s2, s3) of an isotropic law, with its first and second derivatives.

    The stretches s are the singular values of F: I1 = Σ s_i², I2 = Σ_{i<j} s_i² s_j², J = s1 s2 s3.

    Args:
        names: the law's parameters, in the order in which a call takes them.
        program: ψ, ∂ψ/∂(I1, I2, J) and the six second derivatives, of I1, I2, J and the parameters.
    """

    names: tuple[str, ...]
    program: Program

    @classmethod
    def of(cls, material: IsotropicMaterial) -> "StretchEnergy":
        """The energy of ``material``, its parameters left open.

        Raises:
            MaterialError: the energy is no scalar, or holds what has no value at one point.
        """
        invariants = [ufl.variable(ufl.as_ufl(1.0)) for _ in range(3)]
        I1, I2, J = invariants
        symbols = {name: ufl.variable(ufl.as_ufl(1.0)) for name in material.parameters}
        energy = ufl.as_ufl(material.invariant_energy(I1, I2, J, symbols))
        first = [ufl.diff(energy, invariant) for invariant in invariants]
        second = [ufl.diff(first[a], invariants[b]) for a, b in _PAIRS]
        program = Program([energy, *first, *second], [*invariants, *symbols.values()])
        return cls(tuple(symbols), program)

    def __call__(self, stretches: Array, *parameters: Array | float) -> tuple[Array, Array, Array]:
        """ψ (b,), ∂ψ/∂s (b, 3) and ∂²ψ/∂s² (b, 3, 3) [Pa] at stretches (b, 3).

        Args:
            stretches: principal stretches; a view whose columns are contiguous is fastest.
            parameters: a number or (b,) for each of `names`.

        Returns:
            the three, the latter as views of arrays with the points last.
        """
        return of_stretches(lambda I1, I2, J: self.program(I1, I2, J, *parameters), stretches)
