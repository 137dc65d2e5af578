"""What the results of a run tell about the body, whether all of it or a model of it moved."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.recording import FrameMesh

if TYPE_CHECKING:
    from fenics_defo.fem import Solid


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """The body of a run.

    Args:
        points: nodes at rest (n, 3) [m], in the order of the user's file.
        cells: (m, c) rows of ``points``, in the node order of VTK.
        cell_type: a key of `fenics_defo.runtime.NODES_PER_CELL`; empty without cells.
        order: of the displacements.
        dofs: number of unknowns.
        solver: of linear systems.
        ranks: number of processes.
        notes: what reading the mesh changed or noticed.
        more: further entries of the summary.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    cell_type: str
    order: int
    dofs: int
    solver: str
    ranks: int = 1
    notes: tuple[str, ...] = ()
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def frame_mesh(self) -> FrameMesh | None:
        """The mesh of the series for ParaView, if the cells are known."""
        return FrameMesh(self.points, self.cells, self.cell_type) if len(self.cells) else None


def full_body(solid: "Solid", solver: str) -> Body:
    """The record of a body whose nodes all move by themselves.

    Args:
        solid: body.
        solver: of linear systems.
    """
    nodes = solid.nodes
    return Body(
        points=nodes.points,
        cells=nodes.cells,
        cell_type=nodes.cell_type,
        order=solid.order,
        dofs=solid.dof_count,
        solver=solver,
        ranks=solid.comm.size,
        notes=tuple(solid.record.notes),
    )
