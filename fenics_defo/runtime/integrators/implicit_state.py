"""The state of implicit methods, laid out so that an update is one matrix product."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.implicit_rule import Transitions
from fenics_defo.runtime.integrators.scheme import Here

Array = NDArray[np.float64]


class Iteration(NamedTuple):
    """Views for one iteration of Newton's method, from one buffer to another.

    Args:
        q: coordinates of the iterate.
        y: what the mass is multiplied by on the right-hand side.
        x: takes the solution.
        before: rows x, q, v, a of the iterate (4, n), n the number of coordinates of all bodies.
        after: rows q, v, a, y of the next (4, n).
        matrix: takes one to the other (4, 4).
    """

    q: Array
    y: Array
    x: Array
    before: Array
    after: Array
    matrix: Array


class ImplicitState:
    """Three buffers of rows x, q, v, a, y: the last good state stays in one while a step fails.

    Args:
        shape: of the coordinates.
        transitions: of the method.
        iterations: of Newton's method a step.
    """

    def __init__(self, shape: tuple[int, ...], transitions: Transitions, iterations: int) -> None:
        self._buffers = np.zeros((3, 5, *shape))
        self._start = transitions.start
        #: Number of the buffer that holds the last good state.
        self.at = 0
        #: For each buffer to start from: the iterations, the last x in one row, and the buffer
        #: where they end.
        self.paths = tuple(self._path(at, transitions, iterations) for at in range(3))

    @property
    def q(self) -> Array:
        """Coordinates."""
        return np.asarray(self._buffers[self.at, 1])

    @property
    def v(self) -> Array:
        """Velocities."""
        return np.asarray(self._buffers[self.at, 2])

    @property
    def a(self) -> Array:
        """Accelerations."""
        return np.asarray(self._buffers[self.at, 3])

    @property
    def trial(self) -> Array:
        """What the last iteration of a failed step solved for."""
        return self.paths[self.at][0][-1].x

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""
        rows = self._buffers[self.at]
        rows[0], rows[1], rows[2], rows[3] = 0.0, q, v, a
        flat = rows.reshape(5, -1)
        flat[1:] = self._start @ flat[:4]

    def _path(
        self, at: int, transitions: Transitions, iterations: int
    ) -> tuple[tuple[Iteration, ...], Array, int]:
        """Iterations from a buffer over the two others, one after the other."""
        path, here = [], at
        for number in range(iterations):
            there = (at + 1 + number % 2) % 3
            rows, flat = self._buffers[here], self._buffers.reshape(3, 5, -1)
            matrices = transitions.again if number else transitions.first
            path.append(
                Iteration(
                    q=rows[1],
                    y=rows[4],
                    x=rows[0],
                    before=flat[here, :4],
                    after=flat[there, 1:],
                    matrix=matrices[number == iterations - 1],
                )
            )
            here = there
        return tuple(path), path[-1].x.reshape(-1), here


class StateScheme:
    """What schemes over an `ImplicitState` have in common.

    Args:
        here: the force law where the motion is.
        state: of the motion.
    """

    def __init__(self, here: Here, state: ImplicitState) -> None:
        self.here, self._state = here, state

    @property
    def q(self) -> Array:
        """Coordinates."""
        return self._state.q

    @property
    def v(self) -> Array:
        """Velocities."""
        return self._state.v

    @property
    def a(self) -> Array:
        """Accelerations."""
        return self._state.a

    def place(self, q: Array, v: Array, a: Array) -> None:
        """Begin at a state."""
        self._state.place(q, v, a)
        self.here.forget()

    def trial(self) -> Array:
        """What a failed step solved for."""
        return self._state.trial
