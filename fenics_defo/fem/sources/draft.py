"""The mesh while it is being checked: one kind of cell, nodes and cells still coming and going."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.cell_shapes import HEX_EDGES, HEX_FACES, CellShape
from fenics_defo.fem.sources.numbering import row_keys
from fenics_defo.fem.sources.raw_mesh import RawGroup, RawMesh

Integers = NDArray[np.int64]

READABLE = {
    "tetra": CellShape("tetrahedron", 1),
    "tetra10": CellShape("tetrahedron", 2),
    "hexahedron": CellShape("hexahedron", 1),
    "hexahedron20": CellShape("hexahedron", 2),  # completed to 27 nodes
    "hexahedron27": CellShape("hexahedron", 2),
}
ALLOWED = "tetrahedra of 4 or 10 nodes or hexahedra of 8, 20 or 27 nodes"


@dataclass(slots=True, kw_only=True)
class Draft:
    """A mesh of one cell kind under way to a `SourceMesh`; see there for the fields."""

    label: str
    points: NDArray[np.float64]
    node_numbers: Integers
    cells: Integers
    cell_numbers: Integers
    shape: CellShape
    groups: list[RawGroup]
    notes: list[str]

    @property
    def corners(self) -> Integers:
        """(m, 4 or 8) corner vertices of the cells."""
        return self.cells[:, : 4 if self.shape.is_tetrahedron else 8]

    def replace_nodes(self, target: Integers) -> None:
        """Let node ``target[i]`` stand for node i, and drop nodes no cell uses any more.

        Group rows that name a dropped node get -1 there.
        """
        cells = target[self.cells]
        used = np.zeros(len(self.points), dtype=bool)
        used[cells] = True
        new = np.where(used, np.cumsum(used) - 1, -1)
        self.cells = new[cells]
        # -1 in a group row (an earlier drop) must stay -1: it points at the appended last entry.
        mapping = np.append(new[target], -1)
        for group in self.groups:
            if group.dimension < 3:
                group.parts = [mapping[part] for part in group.parts]
        self.points = self.points[used]
        self.node_numbers = self.node_numbers[used]

    def replace_cells(self, target: Integers) -> None:
        """Let cell ``target[i]`` stand for cell i, and drop cells that nothing stands for."""
        kept = np.zeros(len(self.cells), dtype=bool)
        kept[target] = True
        new = np.cumsum(kept) - 1
        for group in self.groups:
            if group.dimension == 3:
                group.parts = [new[target[part]] for part in group.parts]
        self.cells = self.cells[kept]
        self.cell_numbers = self.cell_numbers[kept]

    def place(self, cell: int) -> str:
        """Where a cell is, for a sentence: its number and its centre."""
        centre = self.points[self.corners[cell]].mean(axis=0)
        return f"cell {self.cell_numbers[cell]} at {spot(centre)}"


def spot(point: NDArray[np.float64]) -> str:
    """Coordinates for a sentence."""
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"


def begin_draft(raw: RawMesh) -> Draft:
    """Pick the volume cells of a raw mesh.

    Raises:
        MeshError: no volume cells, several kinds of them, or one that is not supported.
    """
    blocks = [block for block in raw.blocks if block.dimension == 3 and len(block.nodes)]
    kinds = Counter[str]()
    for block in blocks:
        kinds[block.cell_type] += len(block.nodes)
    if not kinds:
        raise MeshError(f"{raw.label} holds {_others(raw)} and no volume cell; {_advice(raw)}")
    if len(kinds) > 1 or not set(kinds) <= set(READABLE):
        listed = ", ".join(f"{count} of type {kind}" for kind, count in sorted(kinds.items()))
        raise MeshError(
            f"{raw.label} holds volume cells of kinds that cannot be used together or at all "
            f"({listed}); mesh the body with one kind: {ALLOWED}"
        )
    kind = next(iter(kinds))
    cells = np.concatenate([block.nodes for block in blocks])
    _check_range(raw, cells)
    draft = Draft(
        label=raw.label,
        points=raw.points,
        node_numbers=raw.node_numbers,
        cells=cells,
        cell_numbers=np.concatenate([block.numbers for block in blocks]),
        shape=READABLE[kind],
        groups=[_checked_group(raw, group) for group in raw.groups],
        notes=list(raw.notes),
    )
    return draft


def complete_serendipity(draft: Draft) -> None:
    """Give hexahedra of 20 nodes their face and body nodes, on exactly the same geometry.

    The serendipity space lies in the triquadratic one, so the 27-node cell through the points of
    the 20-node mapping is the same mapping. At the centre of a face the basis is -1/4 at its
    corners and 1/2 at its mid nodes; at the centre of the cell -1/4 and 1/4.
    """
    cells = draft.cells
    if cells.shape[1] != 20:
        return
    faces = np.array(HEX_FACES)
    edge_of = {frozenset(edge): 8 + i for i, edge in enumerate(HEX_EDGES)}
    mids = np.array(
        [[edge_of[frozenset((f[i], f[(i + 1) % 4]))] for i in range(4)] for f in HEX_FACES]
    )
    (keys,) = row_keys(cells[:, faces].reshape(-1, 4))
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    x = draft.points
    corner_rows = cells[:, faces].reshape(-1, 4)[first]
    mid_rows = cells[:, mids].reshape(-1, 4)[first]
    face_points = 0.5 * x[mid_rows].sum(axis=1) - 0.25 * x[corner_rows].sum(axis=1)
    centres = 0.25 * (x[cells[:, 8:]].sum(axis=1) - x[cells[:, :8]].sum(axis=1))
    n = len(x)
    face_nodes = n + inverse.reshape(-1, 6)
    body_nodes = n + len(first) + np.arange(len(cells))[:, None]
    added = len(first) + len(cells)
    draft.cells = np.hstack([cells, face_nodes, body_nodes])
    draft.points = np.concatenate([x, face_points, centres])
    draft.node_numbers = np.append(
        draft.node_numbers, draft.node_numbers.max() + 1 + np.arange(added)
    )
    draft.notes.append(
        f"the hexahedra of 20 nodes were completed to 27 nodes on the same geometry; "
        f"the {added} new nodes follow those of the file."
    )


def _check_range(raw: RawMesh, cells: Integers) -> None:
    bad = (cells < 0) | (cells >= len(raw.points))
    if np.any(bad):
        row = int(np.flatnonzero(bad.any(axis=1))[0])
        raise MeshError(
            f"{raw.label}: {np.count_nonzero(bad.any(axis=1))} cells refer to nodes outside the "
            f"{len(raw.points)} nodes there are, first cell row {row + 1} with node row "
            f"{cells[row][bad[row]][0]} (allowed: 0 to {len(raw.points) - 1}); mend the mesh"
        )


def _checked_group(raw: RawMesh, group: RawGroup) -> RawGroup:
    """A copy with facet rows outside the nodes marked by -1, to be dropped with the others."""
    parts = [np.asarray(part, dtype=np.int64) for part in group.parts]
    if group.dimension < 3:
        n = len(raw.points)
        parts = [np.where((part >= 0) & (part < n), part, -1) for part in parts]
    return RawGroup(name=group.name, number=group.number, dimension=group.dimension, parts=parts)


def _others(raw: RawMesh) -> str:
    counts = Counter[str]()
    for block in raw.blocks:
        counts[block.cell_type] += len(block.nodes)
    return ", ".join(f"{n} cells of type {kind}" for kind, n in sorted(counts.items())) or "no cell"


def _advice(raw: RawMesh) -> str:
    if any(block.dimension == 2 for block in raw.blocks):
        return (
            "mesh the inside (in Gmsh: `gmsh FILE -3`), or export the closed surface as .stl, "
            ".obj or .ply and give a cell size (--size H, size=H) to fill it with tetrahedra"
        )
    return f"a body needs {ALLOWED}"
