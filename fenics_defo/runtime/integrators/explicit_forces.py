"""What explicit methods divide by the mass."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.integrators.inertia import Inertia
from fenics_defo.runtime.integrators.motion_model import MotionModel
from fenics_defo.runtime.integrators.scheme import Here

Array = NDArray[np.float64]


class ExplicitForces:
    """x = M⁻¹ (g - f(q) - beta K(q) w).

    Args:
        model: what moves.
        inertia: its mass.
        beta: stiffness damping [s].
        shape: of the coordinates.
    """

    def __init__(
        self, model: MotionModel, inertia: Inertia, beta: float, shape: tuple[int, ...]
    ) -> None:
        self.here = Here(model, shape, tangent=beta > 0.0)
        self._beta, self._mass_solve = beta, inertia.solve
        self._right_side, self._drag = np.empty(shape), np.empty((*shape, 1))

    def into(self, x: Array, load: Array, q: Array, w: Array) -> None:
        """Write x."""
        here, right_side = self.here, self._right_side
        target = x if self._mass_solve is None else right_side
        if self._beta:
            force, stiffness = here.both or here.evaluate(q)
            np.matmul(stiffness, w[..., None], self._drag)
            drag = self._drag[..., 0]
            np.multiply(drag, self._beta, drag)
            np.subtract(load, force, target)
            np.subtract(target, drag, target)
        else:
            force = here.evaluate_force(q) if here.force is None else here.force
            np.subtract(load, force, target)
        here.force = here.both = None
        if self._mass_solve is not None:
            self._mass_solve(right_side, x)
