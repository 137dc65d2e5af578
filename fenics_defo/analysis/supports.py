"""Whether a body is held well enough to rest under any load."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.rigid import strainless_motions
from fenics_defo.errors import SolverError
from fenics_defo.fem import Solid


def check_supported(solid: Solid, bound: NDArray[np.bool_]) -> None:
    """Refuse a body that can move without strain.

    Args:
        solid: body.
        bound: (n, 3) components that are held or prescribed.

    Raises:
        SolverError: it can.
    """
    corners = 4 if solid.nodes.cell_type.startswith("tetra") else 8
    free = len(strainless_motions(solid.points, solid.cells, corners, bound))
    if free:
        raise SolverError(
            f"{free} rigid motions of the body or of its parts are not held: it has no equilibrium "
            "under general loads; hold more components, or simulate its motion instead"
        )
