"""Components of the displacement that are not free: held at zero, or prescribed in time."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.histories import History
from fenics_defo.analysis.prescribed import Prescribed
from fenics_defo.errors import LoadError
from fenics_defo.fem import Solid
from fenics_defo.fem.regions import select_nodes

Array = NDArray[np.float64]


def factor(history: History, time: float) -> float:
    """What a history gives at ``time`` [s].

    Raises:
        LoadError: it is no finite number.
    """
    value = history(time)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise LoadError(f"the history {history!r} gave {value!r} at {time:g} s, not a number")
    return number


class Constraints:
    """Which components of this rank's own nodes move how, whatever the forces.

    Where prescribed motions overlap, the later one holds. Collective.

    Args:
        solid: body.
        prescribed: prescribed motions.

    Raises:
        LoadError: a component is prescribed that the body holds at zero.
        SelectionError: a region that the mesh does not have.
    """

    def __init__(self, solid: Solid, prescribed: Sequence[Prescribed]) -> None:
        owner = np.full((solid.nodes.size, 3), -1)
        amount = np.zeros((solid.nodes.size, 3))
        for number, motion in enumerate(prescribed):
            chosen = select_nodes(solid.mesh_data, solid.space, solid.nodes, motion.region)
            for component, value in enumerate(motion.displacement):
                if value is not None:
                    owner[chosen, component], amount[chosen, component] = number, value
        clash = int(((owner >= 0) & solid.held).sum())
        if clash:
            raise LoadError(
                f"{clash} components are both held by the body and prescribed; leave the prescribed"
                " nodes out of what is held, or prescribe other components"
            )
        owned = solid.nodes.owned
        #: (n, 3) bool, all components that are not free, in the user's order.
        self.bound: NDArray[np.bool_] = solid.held | (owner >= 0)
        #: (owned nodes, 3) bool.
        self.free: NDArray[np.bool_] = ~solid.nodes.scatter(self.bound)[:owned]
        #: Whether any component is prescribed, on any rank.
        self.moving = bool((owner >= 0).any())
        mine = solid.nodes.scatter(owner)[:owned]
        #: (owned nodes, 3) bool.
        self.prescribed: NDArray[np.bool_] = mine >= 0
        self._which = mine[self.prescribed]
        self._amount = solid.nodes.scatter(amount)[:owned][self.prescribed]
        self._histories = [motion.history for motion in prescribed]

    def displacement(self, time: float) -> Array:
        """Displacements (k,) [m] of the prescribed components at ``time`` [s]."""
        factors = np.array([factor(history, max(time, 0.0)) for history in self._histories])
        return self._amount * factors[self._which] if self.moving else self._amount

    def rates(self, time: float, step: float) -> tuple[Array, Array]:
        """Velocities and accelerations (k,) of the prescribed components at ``time`` [s].

        Differences over a step to both sides: of second order, and unlike the rules of an
        integrator they do not ring after a kink of the history.

        Args:
            time: [s], from 0.
            step: [s].
        """
        middle = max(time, step)  # at time zero the history begins
        before, at, after = (self.displacement(t) for t in (middle - step, middle, middle + step))
        acceleration = (after - 2.0 * at + before) / step**2
        velocity = (after - before) / (2.0 * step) if time >= step else (at - before) / step
        return velocity, acceleration
