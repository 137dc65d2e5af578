"""The derivative of a body's tangent along a displacement: the third derivatives of its energy."""

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.parts import Part, SampledPart, SmoothPart

Array = NDArray[np.float64]

# Largest change of ∇u between neighbouring samples. The error of the formula, h⁴/30 of the fifth
# derivative, is some 1e-11; that of round-off, which another order of sums would change, 1e-13.
_STEP = 2e-3
# f'(0) ≈ Σ w f(k h) / h of fourth order.
_STENCIL = ((-2, 1.0 / 12.0), (-1, -2.0 / 3.0), (1, 2.0 / 3.0), (2, -1.0 / 12.0))


def add_tangent_derivatives(
    parts: Sequence[Part], local: Array, direction: Array, blocks: BlockMatrix, comm: MPI.Comm
) -> None:
    """Overwrite blocks with H : d, where (H : d) v = d/ds K(u + s d) v at s = 0. Collective.

    By UFL's differentiation where a part has an energy in UFL; for laws at points and for springs
    by central differences of their exact tangents, good to about 1e-10.

    Args:
        parts: what the energy is the sum of.
        local: u (d, 3) [m].
        direction: d (d, 3) [m], ghosts included.
        blocks: overwritten; this rank's share, before its rows go to their owners.
        comm: communicator of the body.
    """
    blocks.clear()
    sampled = [part.with_exact_tangent() for part in parts if isinstance(part, SampledPart)]
    if sampled:
        steepest = max(part.steepest(direction) for part in sampled)
        steepest = comm.allreduce(steepest, op=MPI.MAX)
        if steepest > 0.0:
            _sample(sampled, local, direction, _STEP / steepest, blocks)
    for part in parts:
        if isinstance(part, SmoothPart):
            part.add_tangent_derivative(local, direction, blocks)


def _sample(
    parts: Sequence[SampledPart], local: Array, direction: Array, step: float, blocks: BlockMatrix
) -> None:
    total = np.zeros_like(blocks.values)
    for place, weight in _STENCIL:
        blocks.clear()
        at = local + (place * step) * direction
        for part in parts:
            part.add_tangent(at, blocks, None)
        blocks.values *= weight / step
        total += blocks.values
    blocks.values[:] = total
