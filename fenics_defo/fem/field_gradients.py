"""Gradients of many displacement fields at once, at the quadrature points of some cells."""

from collections.abc import Iterator
from dataclasses import dataclass

import basix
import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.cell_points import mapped_points, reference_gradients
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.material_fields import LawRegion

Array = NDArray[np.float64]

# Cells whose maps are inverted at once, and the fewest whose gradients are formed at once: with
# fewer, NumPy's loops over them do not pay.
_MAPPED = 4096
_FEWEST = 16


@dataclass(frozen=True, slots=True)
class GradientBlock:
    """Gradients of r fields at p points: all points of some cells, the cells running fastest.

    Args:
        cells: (k,) this rank's.
        weights: (p,) of the quadrature, |det J| included [m³].
        gradients: (r, 3, 3, p), [i, a, b] = ∂U_ia/∂X_b; used again for the next block.
    """

    cells: NDArray[np.int32]
    weights: Array
    gradients: Array

    def at_points(self, field: "dolfinx.fem.Function") -> Array:
        """A cell-wise constant function at the points (p,)."""
        values = field.x.array[field.function_space.dofmap.list[self.cells, 0]]
        return np.tile(values, len(self.weights) // len(self.cells))


def region_gradients(
    space: "dolfinx.fem.FunctionSpace",
    region: LawRegion,
    fields: Array,
    *,
    degree: int,
    points: int,
) -> Iterator[GradientBlock]:
    """Walk through the cells of a law that this rank owns, some at a time.

    The memory this takes depends on ``points`` and the number of fields, not on the mesh.

    Args:
        space: displacement space.
        region: the law's cells.
        fields: (r, d, 3) displacements at this rank's nodes, ghosts included.
        degree: polynomial degree that the quadrature integrates exactly.
        points: about how many of them make a block.
    """
    mesh = space.mesh
    kind = basix.CellType[mesh.topology.cell_name()]
    at, weights = basix.make_quadrature(kind, degree)
    reference = reference_gradients(kind, space.element.basix_element.degree, at)
    cells = region.cells[region.cells < mesh.topology.index_map(3).size_local]
    size = max(points // len(at), _FEWEST)
    buffer = np.empty(9 * len(fields) * len(at) * size)
    for begin in range(0, len(cells), _MAPPED):
        some = cells[begin : begin + _MAPPED]
        inverse, scaled = mapped_points(mesh, some, at, weights)
        for first in range(0, len(some), size):
            chosen = slice(first, min(first + size, len(some)))
            functions = np.einsum("qnl,kqlb->qbnk", reference, inverse[chosen], optimize=True)
            functions = np.ascontiguousarray(functions)
            at_nodes = fields[:, space.dofmap.list[some[chosen]].T]
            values = np.ascontiguousarray(np.moveaxis(at_nodes, 3, 1))  # (r, 3, n, k)
            shape = (len(fields), 3, 3, len(at), chosen.stop - first)
            out = buffer[: np.prod(shape)].reshape(shape)
            np.einsum("iank,qbnk->iabqk", values, functions, out=out)
            yield GradientBlock(
                cells=some[chosen],
                weights=np.ascontiguousarray(scaled[chosen].T).ravel(),
                gradients=out.reshape(*shape[:3], -1),
            )
