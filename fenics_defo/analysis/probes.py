"""Displacements at named points."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.analysis.loads import checked_vector
from fenics_defo.analysis.point_location import locate_point
from fenics_defo.errors import LoadError
from fenics_defo.fem import Solid

Array = NDArray[np.float64]


class Probes:
    """Points of a body at rest whose displacements are asked for again and again; collective.

    Args:
        solid: body.
        points: coordinates (3,) [m] by name.

    Raises:
        LoadError: a point is not three numbers, or lies outside of the body.
    """

    def __init__(self, solid: Solid, points: Mapping[str, ArrayLike]) -> None:
        self._comm = solid.comm
        nodes = solid.nodes
        place_of = np.full(nodes.size, -1)
        place_of[nodes.rows[: nodes.owned]] = np.arange(nodes.owned)
        self._places: dict[str, tuple[NDArray[np.int64], Array]] = {}
        for name, point in points.items():
            what = f"probe {name!r}"
            x = np.asarray(checked_vector(what, point, "point"), dtype=np.float64)
            place = locate_point(solid, x, what=what)
            mine = place_of[place.rows]
            self._places[name] = (mine[mine >= 0], place.weights[mine >= 0])

    @property
    def names(self) -> tuple[str, ...]:
        """In the order given."""
        return tuple(self._places)

    def value(self, name: str, field: Array) -> Array:
        """A field (owned nodes, 3) at a probe (3,); collective.

        Raises:
            LoadError: there is no such probe.
        """
        if name not in self._places:
            raise LoadError(f"there is no probe {name!r}; there are {list(self._places)}")
        rows, weights = self._places[name]
        own = weights @ field[rows]
        return np.asarray(own if self._comm.size == 1 else self._comm.allreduce(own))
