"""From arrays in the file's order to DOLFINx's mesh, tags and record."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_defo.energy import MooneyRivlin, StVenantKirchhoff
from fenics_defo.errors import DefoError, MaterialError, MeshError
from fenics_defo.fem.compat import MPI, dolfinx
from fenics_defo.fem.imported import mesh_record
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.fem.sources import Group, RegionMaterial
from tests.unit.fem.fem_bodies import KINDS, bent, mesh_of, source, usual_groups

CASES = [(kind, order) for kind in KINDS for order in (1, 2)]
GROUPS = ["left", "right", "middle", "root", "9", "pins"]


@pytest.mark.parametrize(("kind", "order"), CASES)
def test_groups_hold_the_entities_of_the_file(kind: str, order: int) -> None:
    mesh = source(kind, order=order, groups=usual_groups(kind))
    mesh_data = mesh_of(mesh)
    domain = mesh_data.mesh
    for given, kept in zip(mesh.groups, mesh_data.record.groups, strict=True):
        assert (kept.name, kept.number, kept.dimension) == (
            *(given.name, given.number),
            given.dimension,
        )
        assert kept.size == len(given.entities) > 0
        if given.dimension == 3:
            mine = domain.topology.original_cell_index[kept.entities]
            np.testing.assert_array_equal(np.sort(mine), given.entities)
            continue
        corners = dolfinx.mesh.entities_to_geometry(domain, kept.dimension, kept.entities)
        corners = corners[:, : given.entities.shape[1]]
        found = np.sort(domain.geometry.input_global_indices[corners], axis=1)
        wanted = np.sort(given.entities, axis=1)
        if given.dimension == 0:  # mid nodes are no vertices
            np.testing.assert_array_equal(kept.nodes, given.entities[:, 0])
            wanted = wanted[np.isin(wanted[:, 0], mesh.cells[:, : 4 if kind[0] == "t" else 8])]
        assert set(map(tuple, found)) == set(map(tuple, wanted))


def test_tags_are_dolfinx_tags_and_overlaps_carry_the_lowest_number() -> None:
    mesh = source("tetrahedron", groups=usual_groups("tetrahedron"))
    mesh_data = mesh_of(mesh)
    values = np.empty(len(mesh.cells), int)
    values[mesh_data.mesh.topology.original_cell_index[mesh_data.cell_tags.indices]] = (
        mesh_data.cell_tags.values
    )
    left = np.isin(np.arange(len(mesh.cells)), mesh.groups[0].entities)
    np.testing.assert_array_equal(values, np.where(left, 1, 2))  # 5 lies under 2 everywhere
    assert set(mesh_data.facet_tags.values) == {7}
    assert set(mesh_data.ridge_tags.values) == {9}
    assert set(mesh_data.peak_tags.values) == {4}
    assert {name: tuple(g) for name, g in mesh_data.physical_groups.items()} == {
        **{"left": (3, 1), "right": (3, 2), "middle": (3, 5)},
        **{"root": (2, 7), "9": (1, 9), "pins": (0, 4)},
    }


def test_a_mesh_without_groups_has_no_tags() -> None:
    mesh_data = mesh_of(source("hexahedron"))
    assert mesh_data.cell_tags is mesh_data.facet_tags is None
    assert mesh_data.record.groups == ()


def test_facets_that_the_mesh_lacks_are_left_out() -> None:
    """Three nodes of no common facet, and one facet in any order of its nodes."""
    mesh = source("tetrahedron")
    face = mesh.cells[0, [2, 0, 1]]
    far = np.argsort(mesh.points[:, 0])[[0, len(mesh.points) // 2, -1]]
    group = Group(name="odd", number=1, dimension=2, entities=np.array([face, far]))
    (kept,) = mesh_of(replace(mesh, groups=(group,))).record.groups
    assert len(kept.entities) == 1


@pytest.mark.parametrize(("kind", "order"), CASES)
def test_the_mesh_is_that_of_the_file(kind: str, order: int) -> None:
    mesh = source(kind, order=order, mapping=bent)
    domain = mesh_of(mesh).mesh
    geometry = domain.geometry
    np.testing.assert_array_equal(geometry.x, mesh.points[geometry.input_global_indices])
    assert geometry.cmaps[0].degree == order
    to_vtk = np.argsort(dolfinx.cpp.io.perm_vtk(domain.topology.cell_type, mesh.cells.shape[1]))
    cells = geometry.input_global_indices[geometry.dofmaps[0]][:, to_vtk]
    np.testing.assert_array_equal(cells, mesh.cells[domain.topology.original_cell_index])


SVK = {"young": 1e6, "poisson": 0.3, "density": 1e3}


def with_materials(*items: tuple[str | None, str, dict[str, float]]) -> dict:
    given = tuple(RegionMaterial(region=r, law=law, constants=c) for r, law, c in items)
    mesh = source("tetrahedron", groups=usual_groups("tetrahedron"))
    return dict(mesh_of(replace(mesh, materials=given)).record.materials)


def test_materials_of_the_file() -> None:
    rubber = {"c10": 1e5, "c01": 2e4, "bulk": 1e7, "density": 900.0}
    found = with_materials(("left", "st-venant-kirchhoff", SVK), ("right", "mooney-rivlin", rubber))
    assert found == {"left": StVenantKirchhoff(**SVK), "right": MooneyRivlin(**rubber)}


def test_of_overlapping_materials_the_last_comes_last() -> None:
    soft = SVK | {"young": 1.0}
    law = "st-venant-kirchhoff"
    again = with_materials(("left", law, SVK), ("middle", law, soft), ("left", law, soft))
    assert list(again) == ["middle", "left"]
    assert list(with_materials(("left", law, SVK), (None, law, soft))) == [None]
    assert list(with_materials((None, law, SVK), ("left", law, soft))) == [None, "left"]


def test_a_material_outside_its_range_is_refused() -> None:
    with pytest.raises(MaterialError, match=r"young must .* -1.0"):
        with_materials((None, "st-venant-kirchhoff", SVK | {"young": -1.0}))


def test_on_one_rank_errors_stay_what_they_are() -> None:
    def fail() -> int:
        raise MeshError("no such mesh")

    with pytest.raises(MeshError, match="no such mesh"):
        on_first_rank(MPI.COMM_WORLD, fail)
    assert on_first_rank(MPI.COMM_WORLD, lambda: 3) == 3
    assert issubclass(MeshError, DefoError)


def test_a_foreign_mesh_counts_from_one_in_its_input_order() -> None:
    domain = dolfinx.mesh.create_box(MPI.COMM_WORLD, [[0, 0, 0], [1, 2, 3]], [2, 2, 2])
    record = mesh_record(dolfinx.io.gmsh.MeshData(domain, None, None, None, None, {}))
    np.testing.assert_array_equal(record.node_numbers, np.arange(1, 28))
    np.testing.assert_array_equal(record.cell_numbers, np.arange(1, 49))
    assert record.groups == ()
    assert record.path is None
