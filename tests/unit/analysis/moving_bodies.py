"""Small bodies for the tests of statics and dynamics."""

from functools import cache
from typing import Any

import numpy as np
from modal_bodies import box, dense_pairs
from numpy.typing import NDArray
from scipy import linalg

from fenics_defo.energy import LinearElastic, NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid

Array = NDArray[np.float64]

SOFT = {"young": 1.0e5, "poisson": 0.3, "density": 1000.0}
LINEAR, STVK, NEO = LinearElastic(**SOFT), StVenantKirchhoff(**SOFT), NeoHookean(**SOFT)
SIDES = (1.0, 0.3, 0.2)
TIP = (1.0, 0.3, 0.2)


@cache
def bar(material: Any = LINEAR, *, held: str | None = "x==0", kind: str = "hexahedron") -> Solid:
    fixed = [] if held is None else [held]
    return box((4, 2, 1), SIDES, kind=kind, material=material, fixed=fixed)


@cache
def cube(material: Any = NEO, *, held: str | None = "z==0") -> Solid:
    fixed = [] if held is None else [held]
    return box((2, 2, 2), (1.0, 1.0, 1.0), kind="hexahedron", material=material, fixed=fixed)


def lowest(solid: Solid, number: int = 0, *, lumped: bool = False) -> tuple[float, Array]:
    """ω [rad/s] and shape (n, 3) of a mode, by SciPy; the largest component is 1."""
    if lumped:
        free = np.flatnonzero(~solid.held.ravel())
        stiffness = solid.tangent().toarray()[np.ix_(free, free)]
        masses = np.repeat(solid.lumped_mass(), 3)[free]
        values, vectors = linalg.eigh(stiffness, np.diag(masses))
        shape = np.zeros(solid.held.size)
        shape[free] = vectors[:, number]
        shape = shape.reshape(-1, 3)
    else:
        values, shapes = dense_pairs(solid)
        shape = shapes[number]
    largest = shape.flat[np.abs(shape).argmax()]
    return float(np.sqrt(values[number])), shape / largest
