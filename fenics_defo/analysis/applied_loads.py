"""The user's loads as nodal forces on this rank's own nodes."""

from collections.abc import Sequence
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.constraints import factor
from fenics_defo.analysis.histories import History
from fenics_defo.analysis.inertia_operators import Mass
from fenics_defo.analysis.loads import Gravity, Impulse, Load, PointLoad, Pressure, Traction
from fenics_defo.analysis.point_location import Place, locate_node, locate_point
from fenics_defo.errors import LoadError
from fenics_defo.fem import Solid
from fenics_defo.fem.regions import select_nodes
from fenics_defo.fem.surface_loads import PressureForm, surface_weights

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Dead:
    """A force that does not depend on the displacement.

    Args:
        history: its factor.
        force: (owned nodes, 3) [N].
    """

    history: History
    force: Array


class AppliedLoads:
    """Sum of all loads; collective.

    Args:
        solid: body.
        loads: what acts on it.
        mass: of its nodes, consistent or lumped: gravity takes the same.

    Raises:
        LoadError: something that is no load, or a point outside of the body.
        SelectionError: a region that the mesh does not have.
    """

    def __init__(self, solid: Solid, loads: Sequence[Load], mass: Mass) -> None:
        self._solid = solid
        self._shape = (solid.nodes.owned, 3)
        self._dead: list[_Dead] = []
        self._known: tuple[tuple[float, ...], Array] | None = None
        self._pressures: list[tuple[Pressure, PressureForm]] = []
        #: Impulses and their nodal momenta (owned nodes, 3) [N s].
        self.impulses: list[tuple[Impulse, Array]] = []
        for load in as_loads(loads):
            match load:
                case Gravity():
                    field = np.broadcast_to(np.asarray(load.vector), self._shape)
                    self._dead.append(_Dead(load.history, mass.apply(np.ascontiguousarray(field))))
                case Traction():
                    weights = surface_weights(solid, load.region)
                    self._dead.append(_Dead(load.history, np.outer(weights, load.vector)))
                case PointLoad():
                    place = _place(solid, load, "a point load")
                    self._dead.append(_Dead(load.history, self._spread(place, load.vector)))
                case Pressure():
                    self._pressures.append((load, PressureForm(solid, load.region)))
                case Impulse():
                    self.impulses.append((load, self._momentum(load)))

    @property
    def follows(self) -> bool:
        """Whether the forces depend on the displacement."""
        return bool(self._pressures)

    def force(self, time: float, local: Array) -> Array:
        """Nodal forces (owned nodes, 3) [N]; collective.

        Args:
            time: [s].
            local: displacement (d, 3) [m] of this rank's nodes, ghosts included.
        """
        total = self._dead_force(time)
        for load, form in self._pressures:
            amount = load.value * factor(load.history, time)
            if amount != 0.0:
                total = total + form.force(local, amount)[: self._shape[0]]
        return total

    def _dead_force(self, time: float) -> Array:
        """Sum of the forces that do not follow; made again only when a factor has changed."""
        amounts = tuple(factor(dead.history, time) for dead in self._dead)
        if self._known is None or self._known[0] != amounts:
            total = np.zeros(self._shape)
            for amount, dead in zip(amounts, self._dead, strict=True):
                if amount != 0.0:
                    total += amount * dead.force
            total.setflags(write=False)
            self._known = (amounts, total)
        return self._known[1]

    def add_tangent(
        self, matrix: PETSc.Mat, time: float, local: Array, *, factor_of_all: float, symmetric: bool
    ) -> None:
        """Add a multiple of the derivative of the forces to a matrix; collective.

        Args:
            matrix: from `Assembly.empty_matrix`.
            time: [s].
            local: displacement (d, 3) [m].
            factor_of_all: -1 for a stiffness.
            symmetric: only its symmetric part.
        """
        for load, form in self._pressures:
            amount = load.value * factor(load.history, time)
            if amount != 0.0:
                form.add_tangent(matrix, local, factor_of_all * amount, symmetric=symmetric)

    def _momentum(self, impulse: Impulse) -> Array:
        if impulse.region is None:
            return self._spread(_place(self._solid, impulse, "an impulse"), impulse.vector)
        solid = self._solid
        chosen = select_nodes(solid.mesh_data, solid.space, solid.nodes, impulse.region)
        weights = np.where(chosen, solid.lumped_mass(), 0.0)
        rows = solid.nodes.rows[: self._shape[0]]
        return np.outer(weights[rows] / weights.sum(), impulse.vector)

    def _spread(self, place: Place, vector: Sequence[float]) -> Array:
        """A vector shared out among the nodes of a place (owned nodes, 3)."""
        weights = np.zeros(self._solid.nodes.size)
        np.add.at(weights, place.rows, place.weights)
        return np.outer(weights[self._solid.nodes.rows[: self._shape[0]]], vector)


def as_loads(loads: object) -> tuple[Load, ...]:
    """Loads, or a single one, as a tuple.

    Raises:
        LoadError: something is no load.
    """
    kinds = (Gravity, Traction, Pressure, PointLoad, Impulse)
    given = tuple(loads) if isinstance(loads, Sequence) else (loads,)
    for load in given:
        if not isinstance(load, kinds):
            raise LoadError(
                f"a load must be Gravity, Traction, Pressure, PointLoad or Impulse, got {load!r}"
            )
    return given


def _place(solid: Solid, load: PointLoad | Impulse, what: str) -> Place:
    if load.node is not None:
        return locate_node(solid, load.node, what=what)
    return locate_point(solid, np.asarray(load.point, dtype=np.float64), what=what)
