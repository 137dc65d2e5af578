"""Many steps of many oscillators at once, without a Python loop over steps."""

from itertools import pairwise
from math import isqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_BLOCK = 64  # steps of a block, at most
_WIDTH = 12800  # numbers in one operation: in the cache, and many enough to outweigh its call


class FilterBlocks:
    """s' = E s + g p for n oscillators with states s = (z, v).

    A chunk of steps is cut into blocks. Their ends, begun at rest, are weighted sums of the loads;
    with these the states at the beginnings follow from one block to the next. Then all blocks are
    stepped side by side, by the recursion that z and its free continuation o = E₁₁ z + E₁₂ v obey:

        z' = o + g₁ p,   o' = tr(E) o - det(E) z + (E₁₁ g₁ + E₁₂ g₂) p.

    Within a block it loses up to the square of the number of steps times the round-off of z: 1e-12.

    Args:
        transition: E (2, 2, n).
        input_effect: g (2, n).
    """

    def __init__(self, transition: Array, input_effect: Array) -> None:
        n = input_effect.shape[1]
        powers = np.empty((_BLOCK + 1, 2, 2, n))
        powers[0] = np.eye(2)[:, :, None]
        for i in range(_BLOCK):
            powers[i + 1] = np.einsum("ijn,jkn->ikn", transition, powers[i])
        self._powers = powers
        # Effects of a load on the state that many steps later, the longest ago first.
        effects = np.einsum("tijn,jn->itn", powers[:_BLOCK], input_effect)
        self._effects = np.ascontiguousarray(effects[:, ::-1])
        (self._zz, self._zv), (vz, vv) = transition
        self._trace = self._zz + vv
        self._determinant = self._zz * vv - self._zv * vz
        self._direct = input_effect[0]
        self._ahead = self._zz * input_effect[0] + self._zv * input_effect[1]
        self._blocks = max(16, min(1024, _WIDTH // n))
        #: Steps that it does at once.
        self.chunk = _BLOCK * self._blocks

    def run(self, loads: Array, state: Array, out: Array) -> Array:
        """Do t steps.

        Args:
            loads: p (t, n), contiguous.
            state: s (2, n) before the first step.
            out: takes z (t, n) after each step; contiguous, not ``loads`` itself.

        Returns:
            s (2, n) after the last.
        """
        done, steps = 0, len(loads)
        while done < steps:
            rest = steps - done
            block = min(_BLOCK, isqrt(rest))
            blocks = min(self._blocks, rest // block)
            end = done + block * blocks
            shape = (blocks, block, loads.shape[1])
            state = self._chunk(loads[done:end].reshape(shape), state, out[done:end].reshape(shape))
            done = end
        return state

    def _chunk(self, loads: Array, state: Array, out: Array) -> Array:
        """Blocks of steps: loads and out are (blocks, steps, n)."""
        blocks, block, n = loads.shape
        starts = np.empty((blocks + 1, 2, n))
        for row in range(2):
            effects = self._effects[row, _BLOCK - block :]
            np.einsum("bjn,jn->bn", loads, effects, out=starts[1:, row])
        starts[0] = state
        over, products, term = self._powers[block], np.empty((2, 2, n)), np.empty((2, n))
        multiply, add, reduce = np.multiply, np.add, np.add.reduce
        for before, after in pairwise(starts):
            multiply(over, before, products)
            reduce(products, 1, out=term)
            add(after, term, after)
        z, v = starts[:-1].transpose(1, 0, 2)
        free, term = self._zz * z + self._zv * v, np.empty((blocks, n))
        trace, determinant, direct = self._trace, self._determinant, self._direct
        for j in range(block):
            load, position = loads[:, j], out[:, j]
            multiply(load, direct, term)
            add(free, term, position)
            multiply(free, trace, free)
            multiply(z, determinant, term)
            np.subtract(free, term, free)
            multiply(load, self._ahead, term)
            add(free, term, free)
            z = position
        return starts[-1]
