"""Implicit steps of linear models: the one matrix is inverted once."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.implicit_rule import Transitions
from fenics_defo.runtime.integrators.implicit_state import ImplicitState, StateScheme
from fenics_defo.runtime.integrators.inertia import Inertia, product
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Here

Array = NDArray[np.float64]


class LinearStep(StateScheme):
    """A scheme; see `Transitions` for its equations. One iteration solves them.

    Args:
        model: what moves, with a law of the kind "linear".
        inertia: its mass.
        transitions: of the method.
        shape: of the coordinates.
    """

    def __init__(
        self,
        model: MotionModel,
        inertia: Inertia,
        transitions: Transitions,
        *,
        shape: tuple[int, ...],
    ) -> None:
        super().__init__(Here(model, shape, tangent=True), ImplicitState(shape, transitions, 1))
        self._mass_times = inertia.times
        rest = np.zeros(shape[-1:])
        stiffness = np.array(model.law.evaluator(rest.shape).force_and_stiffness(rest)[1])
        matrix = stiffness + transitions.mass_scale * inertia.matrix
        self._stiffness_times = product(stiffness, shape)
        self._solve = product(np.linalg.inv(matrix), shape)
        self._right_side, self._term = np.empty(shape), np.empty(shape)

    def advance(self, load: Array) -> float:
        """Do one step; a number that is not finite tells that it failed and nothing changed."""
        state, right_side, term = self._state, self._right_side, self._term
        ((q, y, x, before, after, transition),), flat, end = state.paths[state.at]
        self._stiffness_times(q, term)
        np.subtract(load, term, right_side)
        if self._mass_times is not None:
            self._mass_times(y, term)
            y = term
        np.subtract(right_side, y, right_side)
        self._solve(right_side, x)
        np.dot(transition, before, after)
        size: float = flat.dot(flat)
        if size < np.inf:
            state.at = end
            self.here.forget()
        return size
