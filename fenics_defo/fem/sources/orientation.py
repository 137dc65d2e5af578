"""Jacobian determinants: cells inside out are turned, flat and folded cells are refused."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.cell_shapes import jacobian_determinants
from fenics_defo.fem.sources.draft import Draft

# A determinant over the cube of the longest edge does not depend on the unit of length; it is
# 0.7 for a regular tetrahedron and about height / edge for a flat one. Below 1e-12 the height is
# lost in double precision as soon as stiffness terms (squares of 1 / height) are added.
FLAT = 1e-12
# Rounding of coordinates at distance D from the origin moves a node by eps D, which changes a
# determinant by about eps D L^2; the factor covers the sum over the nodes.
ROUNDING = 32.0 * np.finfo(float).eps


def orient(draft: Draft) -> None:
    """Bring every cell to positive determinants.

    Raises:
        MeshError: cells without volume, or with determinants of both signs.
    """
    shape = draft.shape
    determinants = jacobian_determinants(draft.points, draft.cells, shape=shape, at=shape.probes)
    noise = _noise(draft)
    lowest, highest = determinants.min(axis=1), determinants.max(axis=1)
    size = np.maximum(np.abs(lowest), np.abs(highest))
    # Written so that NaN and overflow count as flat.
    flat = ~(size > noise)
    if np.any(flat):
        worst = int(np.flatnonzero(flat)[0])
        raise MeshError(
            f"{draft.label}: {np.count_nonzero(flat)} of {len(flat)} cells have no volume, first "
            f"{draft.place(worst)} (Jacobian determinant {size[worst]:.3g}, rounding leaves "
            f"{noise[worst]:.3g}); remove flat cells or re-mesh"
        )
    folded = (lowest < -noise) & (highest > noise)
    if np.any(folded):
        quotient = np.where(folded, -np.minimum(-lowest, highest) / size, 0.0)
        worst = int(np.argmin(quotient))
        raise MeshError(
            f"{draft.label}: {np.count_nonzero(folded)} of {len(folded)} cells are folded (their "
            f"Jacobian determinant changes sign inside), worst {draft.place(worst)} with "
            f"{lowest[worst]:.3g} to {highest[worst]:.3g}; check the node order or re-mesh"
        )
    turned = highest <= noise
    if np.any(turned):
        draft.cells[turned] = draft.cells[turned][:, shape.mirror]
        draft.notes.append(
            f"{np.count_nonzero(turned)} of {len(turned)} cells were inside out (negative volume) "
            "and have been reordered."
        )


def _noise(draft: Draft) -> NDArray[np.float64]:
    """(m,) determinant below which a cell counts as flat [m³]."""
    x = draft.points
    squares = np.zeros(len(draft.cells))
    for a, b in draft.shape.edges:
        edge = x[draft.cells[:, a]] - x[draft.cells[:, b]]
        np.maximum(squares, np.einsum("mi,mi->m", edge, edge), out=squares)
    length = np.sqrt(squares)
    return FLAT * length**3 + ROUNDING * np.abs(x).max() * squares
