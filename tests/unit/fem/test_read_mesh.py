"""``read_mesh`` and ``build_mesh``: file or arrays in, DOLFINx mesh with its record out."""

import logging
from pathlib import Path

import meshio
import numpy as np
import pytest

from fenics_defo import fem
from fenics_defo.errors import MeshError
from fenics_defo.fem.compat import MPI
from fenics_defo.fem.imported import MeshData
from tests.unit.fem.fem_bodies import box, mesh_of, source

KINDS = {4: "tetra", 10: "tetra10", 8: "hexahedron", 27: "hexahedron27"}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
def test_a_file_and_its_arrays_give_the_same_mesh(kind: str, order: int, tmp_path: Path) -> None:
    points, cells = box(kind, order=order)
    path = tmp_path / "body.vtu"
    meshio.Mesh(points, [(KINDS[cells.shape[1]], cells)]).write(path)
    read, built = fem.read_mesh(path), fem.build_mesh(points, cells, kind=kind)
    assert isinstance(read, MeshData)
    for mesh_data in (read, built):
        mesh = mesh_data.mesh
        np.testing.assert_array_equal(mesh.geometry.x, points[mesh.geometry.input_global_indices])
        assert mesh.topology.cell_name() == kind
        assert mesh.geometry.cmaps[0].degree == order
        np.testing.assert_array_equal(mesh_data.record.node_numbers, np.arange(1, len(points) + 1))
        np.testing.assert_array_equal(mesh_data.record.cell_numbers, np.arange(1, len(cells) + 1))
    assert read.record.path == path
    assert built.record.path is None


def test_notes_are_logged_and_kept(caplog: pytest.LogCaptureFixture) -> None:
    points, cells = box("tetrahedron")
    lonely = np.vstack([points, [[9.0, 9.0, 9.0]]])
    with caplog.at_level(logging.WARNING):
        mesh_data = fem.build_mesh(lonely, cells)
    assert mesh_data.record.notes
    assert [record.message for record in caplog.records] == list(mesh_data.record.notes)
    assert mesh_data.mesh.geometry.x.max() < 9.0


@pytest.mark.parametrize("name", ["missing.msh", "body.doc"])
def test_what_cannot_be_read_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / "body.doc").write_text("x")
    with pytest.raises(MeshError, match=name):
        fem.read_mesh(tmp_path / name)


def test_arrays_of_a_wrong_shape_are_refused() -> None:
    with pytest.raises(MeshError, match=r"\(5,\)|\(m, 4\)"):
        fem.build_mesh(np.zeros((4, 3)), np.arange(5))


def test_another_communicator() -> None:
    mesh_data = fem.build_mesh(*box("hexahedron"), kind="hexahedron", comm=MPI.COMM_SELF)
    assert mesh_data.mesh.comm.size == 1
    own = mesh_of(source("hexahedron", seed=0))
    np.testing.assert_array_equal(own.mesh.geometry.x, mesh_data.mesh.geometry.x)
