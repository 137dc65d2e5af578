"""A DOLFINx mesh that remembers its file: numbers of nodes and cells, groups, materials."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import Law
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.input_order import input_nodes

__all__ = ["EntityGroup", "ImportedMesh", "MeshData", "MeshRecord", "mesh_record"]

if TYPE_CHECKING:
    from dolfinx.io.gmsh import MeshData
else:
    MeshData = dolfinx.io.gmsh.MeshData


@dataclass(frozen=True, slots=True, kw_only=True)
class EntityGroup:
    """A named and numbered group of a mesh's entities: gmsh's physical group, Abaqus's set, ...

    Args:
        name: its name in the file; its number as text where it has none.
        number: its number in the file.
        dimension: 3 for cells, 2 for facets, 1 for edges, 0 for vertices.
        entities: (k,) int32, this rank's indices of its entities in the DOLFINx mesh, ghosts
            included, ascending.
        size: number of its entities in the file.
        nodes: (k,) int64, for a set of nodes their rows in the file's list, the same on each
            rank: ``entities`` cannot hold the mid nodes of second-order cells. None otherwise.
    """

    name: str
    number: int
    dimension: int
    entities: NDArray[np.int32]
    size: int
    nodes: NDArray[np.int64] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshRecord:
    """What the user's file says beside the mesh; the same on each rank but for groups' entities.

    Args:
        path: the file, None for arrays.
        node_numbers: (n,) int64, number that the file gives each node.
        cell_numbers: (m,) int64, number that the file gives each cell.
        groups: the file's groups.
        materials: region name (None: everywhere) -> material, where the file has materials.
        notes: one sentence for each thing that reading changed or noticed.
    """

    path: Path | None
    node_numbers: NDArray[np.int64]
    cell_numbers: NDArray[np.int64]
    groups: tuple[EntityGroup, ...] = ()
    materials: Mapping[str | None, Law] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


class ImportedMesh(MeshData):
    """DOLFINx's own ``MeshData`` with the record of the file it came from, as ``record``."""

    record: MeshRecord


def mesh_record(mesh_data: MeshData) -> MeshRecord:
    """The record of a mesh of ours, or one made from the tags of any other ``MeshData``.

    Collective on the mesh's communicator where the mesh is not ours.

    Args:
        mesh_data: what ``read_mesh``, ``build_mesh`` or DOLFINx's own gmsh reader returned.

    Returns:
        the record; a foreign mesh counts its nodes and cells from one, in their input order.
    """
    record = getattr(mesh_data, "record", None)
    return record if isinstance(record, MeshRecord) else _record_of_tags(mesh_data)


def _record_of_tags(mesh_data: MeshData) -> MeshRecord:
    mesh = mesh_data.mesh
    tags = {
        3: mesh_data.cell_tags,
        2: mesh_data.facet_tags,
        1: mesh_data.ridge_tags,
        0: mesh_data.peak_tags,
    }
    physical = mesh_data.physical_groups or {}
    names = {(group.dim, group.tag): name for name, group in physical.items()}
    groups = []
    for dimension, tag in tags.items():
        local = np.unique(tag.values) if tag is not None else np.empty(0, np.int32)
        for number in sorted(set(np.concatenate(mesh.comm.allgather(local)).tolist())):
            entities = tag.find(number) if tag is not None else np.empty(0, np.int32)
            owned = mesh.topology.index_map(dimension).size_local
            groups.append(
                EntityGroup(
                    name=names.get((dimension, number)) or str(number),
                    number=int(number),
                    dimension=dimension,
                    entities=entities,
                    size=int(mesh.comm.allreduce(int((entities < owned).sum()))),
                )
            )
    return MeshRecord(
        path=None,
        node_numbers=1 + input_nodes(mesh),
        cell_numbers=np.arange(1, 1 + mesh.topology.index_map(3).size_global),
        groups=tuple(groups),
    )
