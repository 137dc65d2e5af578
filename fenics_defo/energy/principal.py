"""Isotropic energies as functions of the principal stretches."""

from dataclasses import dataclass

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo.energy.evaluation import Program
from fenics_defo.energy.material import IsotropicMaterial

type Array = NDArray[np.float64]

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


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
        symbols = {name: ufl.variable(ufl.as_ufl(1.0)) for name in material.parameters}
        energy = ufl.as_ufl(material.invariant_energy(*invariants, symbols))
        first = [ufl.diff(energy, invariant) for invariant in invariants]
        second = [ufl.diff(first[a], invariants[b]) for a, b in _PAIRS]
        program = Program([energy, *first, *second], [*invariants, *symbols.values()])
        return cls(tuple(symbols), program)

    def __call__(self, stretches: Array, *parameters: Array | float) -> tuple[Array, Array, Array]:
        """ψ (b,), ∂ψ/∂s (b, 3) and ∂²ψ/∂s² (b, 3, 3) [Pa] at stretches (b, 3).

        By the chain rule, with i, j, k distinct: ∂_i I1 = 2 s_i, ∂_i I2 = 2 s_i (I1 − s_i²),
        ∂_i J = s_j s_k; ∂_ii I1 = 2, ∂_ii I2 = 2 (I1 − s_i²), ∂_ij I2 = 4 s_i s_j, ∂_ij J = s_k.

        Args:
            stretches: principal stretches; a view whose columns are contiguous is fastest.
            parameters: a number or (b,) for each of `names`.

        Returns:
            the three, the latter as views of arrays with the points last.
        """
        s = stretches.T
        squares = s * s
        I1 = squares[0] + squares[1] + squares[2]
        others = I1 - squares  # Σ_{j≠i} s_j²
        I2 = squares[0] * squares[1] + squares[2] * others[2]
        minors = np.stack([s[1] * s[2], s[0] * s[2], s[0] * s[1]])
        J = s[0] * minors[0]
        energy, *rest = self.program(I1, I2, J, *parameters)
        slopes, curvatures = rest[:3], dict(zip(_PAIRS, rest[3:], strict=True))
        twice = 2.0 * s
        gradients = (twice, twice * others, minors)  # of I1, I2 and J, each (3, b)
        stress = sum(slope * gradient for slope, gradient in zip(slopes, gradients, strict=True))
        second = np.empty((3, 3, *J.shape))
        # Rows of Σ_b ∂²ψ/∂a∂b ∂_j b for a = I1, I2, J.
        rows = [
            sum(curvatures[min(a, b), max(a, b)] * gradients[b] for b in range(3)) for a in range(3)
        ]
        for i, j in _PAIRS:
            entry = sum(gradients[a][i] * rows[a][j] for a in range(3))
            if i == j:
                entry = entry + 2.0 * (slopes[0] + slopes[1] * others[i])
            else:
                entry = entry + slopes[1] * (twice[i] * twice[j]) + slopes[2] * s[3 - i - j]
            second[i, j] = second[j, i] = entry
        return energy, stress.T, second.transpose(2, 0, 1)
