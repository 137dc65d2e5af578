"""Implicit steps by a fixed number of Newton iterations; one linear solve each."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.dense_solver import solve
from fenics_defo.runtime.integrators.implicit_rule import Transitions
from fenics_defo.runtime.integrators.implicit_state import ImplicitState, StateScheme
from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Here

Array = NDArray[np.float64]


class NewtonStep(StateScheme):
    """A scheme; see `Transitions` for its equations.

    Args:
        model: what moves.
        inertia: its mass.
        transitions: of the method.
        iterations: of Newton's method a step.
        shape: of the coordinates.
    """

    def __init__(
        self,
        model: MotionModel,
        inertia: Inertia,
        transitions: Transitions,
        *,
        iterations: int,
        shape: tuple[int, ...],
    ) -> None:
        super().__init__(
            Here(model, shape, tangent=True), ImplicitState(shape, transitions, iterations)
        )
        self._mass_times = inertia.times
        self._mass = transitions.mass_scale * inertia.matrix
        self._matrix = np.empty((*shape, shape[-1]))
        self._right_side, self._inertia = np.empty(shape), np.empty(shape)
        # The functions of a step, bound once: looking them up would cost as much as one of them.
        self._step = (self.here.evaluate, np.subtract, np.add, np.dot, solve)

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""
        evaluate, subtract, add, dot, solve = self._step
        state, times = self._state, self._mass_times
        right_side, matrix, mass = self._right_side, self._matrix, self._mass
        known, (path, flat, end) = self.here.both, state.paths[state.at]
        self.here.both = None
        for q, y, x, before, after, transition in path:
            force, stiffness = known or evaluate(q)
            known = None
            subtract(load, force, right_side)
            if times is not None:
                times(y, self._inertia)
                y = self._inertia
            subtract(right_side, y, right_side)
            add(stiffness, mass, matrix)
            solve(matrix, right_side, x)
            dot(transition, before, after)
        size: float = flat.dot(flat)
        if size < np.inf:
            state.at = end
            self.here.force = None
        return size
