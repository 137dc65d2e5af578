"""Loads and masses of a body as forces on reduced coordinates."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Impulse, Load
from fenics_defo.analysis.applied_loads import AppliedLoads, as_loads
from fenics_defo.analysis.inertia_operators import ConsistentMassOperator, LumpedMass, Mass
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection

Array = NDArray[np.float64]

type MassKind = Literal["consistent", "lumped"]


def mass_of(solid: Solid, kind: MassKind) -> Mass:
    """The mass that gravity and inertia take: lumped for explicit integrators.

    Raises:
        DefoError: another kind.
    """
    if kind not in ("consistent", "lumped"):
        raise DefoError(
            'mass must be "consistent", or "lumped" to compare with an explicit integrator of the '
            f"full simulation, got {kind!r}"
        )
    make = LumpedMass if kind == "lumped" else ConsistentMassOperator
    return make(solid.assembly)


def reduced_mass(solid: Solid, projection: Projection, mass: Mass) -> Array:
    """Uᵀ M U (r, r); collective."""
    owned = solid.nodes.owned
    columns = [projection.project(mass.apply(field[:owned])) for field in projection.fields]
    matrix = np.array(columns)
    return 0.5 * (matrix + matrix.T)


def gravity_rows(solid: Solid, projection: Projection, mass: Mass) -> Array:
    """Forces (3, r) by unit accelerations along x, y and z; collective."""
    shape = (solid.nodes.owned, 3)
    fields = [np.ascontiguousarray(np.broadcast_to(axis, shape)) for axis in np.eye(3)]
    return np.array([projection.project(mass.apply(field)) for field in fields])


def projected_loads(
    solid: Solid, projection: Projection, mass: Mass, loads: Sequence[Load] | Mapping[str, Load]
) -> dict[str, Array]:
    """Forces (r,) of loads at their full value, an impulse's momentum among them; collective.

    Pressure acts as on the surface at rest: within the coordinates it does not follow the body.

    Args:
        solid: body.
        projection: of it.
        mass: that gravity acts on.
        loads: by name, or one after the other: then each is called by its kind, "traction", say,
            and a second one of the kind "traction 2".

    Raises:
        LoadError: something that is no load, or a point outside of the body.
        SelectionError: a region that the mesh does not have.
    """
    named = dict(loads) if isinstance(loads, Mapping) else _named(as_loads(loads))
    at_rest = np.zeros((len(solid.nodes.rows), 3))
    found = {}
    for name, load in named.items():
        (checked,) = as_loads(load)
        if isinstance(checked, Impulse):
            ((_, force),) = AppliedLoads(solid, [checked], mass).impulses
        else:
            full = replace(checked, history=_full)
            force = AppliedLoads(solid, [full], mass).force(0.0, at_rest)
        found[name] = projection.project(force)
    return found


def _full(_: float) -> float:
    return 1.0


def _named(loads: Sequence[Load]) -> dict[str, Load]:
    named: dict[str, Load] = {}
    for load in loads:
        kind = type(load).__name__.removesuffix("Load").lower()
        count = sum(name.split()[0] == kind for name in named)
        named[f"{kind} {count + 1}" if count else kind] = load
    return named
