"""Faults of meshes given as arrays: mended and noted, or refused in one sentence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from source_bodies import assert_mids_in_the_middle, bend, body, corner_volume, hex_box, tet_box

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources import source_from_arrays
from fenics_defo.fem.sources.cell_shapes import CellShape, jacobian_determinants

SHAPES = [("tetrahedron", 4), ("tetrahedron", 10), ("hexahedron", 8), ("hexahedron", 20),
          ("hexahedron", 27)]  # fmt: skip


def mapped_volume(mesh):
    """Volume by a Gauss rule of degree 7, enough for the determinants of second-order cells."""
    shape = CellShape(mesh.kind, mesh.order)
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    a, b, c = (m.ravel() for m in np.meshgrid(x, x, x, indexing="ij"))
    weights = np.einsum("i,j,k->ijk", w, w, w).ravel()
    at = np.column_stack([a, b, c])
    if mesh.kind == "tetrahedron":  # Duffy's map of the cube to the simplex
        at = np.column_stack([a, b * (1 - a), c * (1 - a) * (1 - b)])
        weights = weights * (1 - a) ** 2 * (1 - b)
    return (jacobian_determinants(mesh.points, mesh.cells, shape=shape, at=at) @ weights).sum()


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize(("kind", "nodes"), SHAPES)
def test_a_sound_mesh_is_kept(kind, nodes, curved):
    points, cells = body(kind, nodes, size=(1.0, 2.0, 3.0))
    points = bend(points) if curved else points
    mesh = source_from_arrays(points, cells, kind=kind)
    assert mesh.order == {4: 1, 8: 1}.get(nodes, 2)
    np.testing.assert_array_equal(mesh.points[: len(points)], points)
    np.testing.assert_array_equal(mesh.cells[:, :nodes], cells)
    if nodes != 20:
        assert mesh.notes == ()
    if mesh.order == 2 or not curved:
        assert mapped_volume(mesh) == pytest.approx(6.0, rel=1e-12)


def test_completed_serendipity_cells_keep_their_geometry():
    full, cells = body("hexahedron", 27)
    expected = full + 0.05 * np.sin(full[:, [1, 2, 0]])
    rng = np.random.default_rng(1)
    corners = cells[:, :20]
    used = np.unique(corners)
    points = expected[used] + 0.01 * rng.random((len(used), 3))
    mesh = source_from_arrays(points, np.searchsorted(used, corners), kind="hexahedron")
    # The serendipity basis at (r, s, t) in [-1, 1]^3 (Zienkiewicz and Taylor), at face centres:
    signs = 2.0 * CellShape("hexahedron", 2).reference_nodes[:20] - 1.0
    at = 2.0 * CellShape("hexahedron", 2).reference_nodes[20:] - 1.0
    x = points[np.searchsorted(used, corners)]
    products = 1.0 + at[:, None, :] * signs
    corner = products.prod(axis=2) * ((at[:, None, :] * signs).sum(axis=2) - 2.0) / 8.0
    bubble = np.where(signs == 0.0, 1.0 - at[:, None, :] ** 2, products).prod(axis=2) / 4.0
    basis = np.where((signs == 0.0).any(axis=1), bubble, corner)
    np.testing.assert_allclose(basis.sum(axis=1), 1.0)
    np.testing.assert_allclose(
        mesh.points[mesh.cells[:, 20:]], np.einsum("qc,mci->mqi", basis, x), atol=1e-13
    )


@settings(max_examples=40, deadline=None)
@given(shape=st.sampled_from(SHAPES), seed=st.integers(0, 2**32 - 1))
def test_numbering_and_orientation_do_not_matter(shape, seed):
    """Shuffled nodes and cells, some cells mirrored: the same body comes out, right way round."""
    kind, nodes = shape
    rng = np.random.default_rng(seed)
    points, cells = body(kind, nodes, n=1, size=(1.0, 2.0, 3.0))
    order = rng.permutation(len(points))
    inverse = np.argsort(order)
    shuffled = inverse[cells][rng.permutation(len(cells))]
    mirror = CellShape(kind, {4: 1, 8: 1}.get(nodes, 2)).mirror
    turned = rng.random(len(cells)) < 0.5
    # A mirrored cell of 20 nodes has its nodes among the first 20, too.
    shuffled[turned] = shuffled[turned][:, mirror[:nodes]]
    mesh = source_from_arrays(points[order], shuffled, kind=kind)
    assert mapped_volume(mesh) == pytest.approx(6.0)
    np.testing.assert_array_equal(mesh.points[: len(points)], points[order])
    assert [sorted(row[:nodes]) for row in mesh.cells] == [sorted(row) for row in shuffled]
    assert any("inside out" in note for note in mesh.notes) == bool(turned.any())
    if mesh.order == 2:
        assert_mids_in_the_middle(mesh)


def test_the_number_of_mirrored_cells_is_told():
    points, cells = tet_box(2)
    cells[:5] = cells[:5][:, [1, 0, 2, 3]]
    (note,) = source_from_arrays(points, cells).notes
    assert note.startswith("5 of 48 cells were inside out")


def test_unused_nodes_are_dropped_even_if_they_are_not_numbers():
    points, cells = tet_box(1)
    points = np.vstack([[np.nan] * 3, points, [9.0, 9.0, 9.0]])
    mesh = source_from_arrays(points, cells + 1)
    np.testing.assert_array_equal(mesh.points, points[1:-1])
    np.testing.assert_array_equal(mesh.node_numbers, np.arange(2, 10))
    assert any("2 of 10 nodes" in note for note in mesh.notes)


def test_pieces_are_noted():
    points, cells = tet_box(1)
    mesh = source_from_arrays(
        np.vstack([points, points + 5.0]), np.vstack([cells, cells + len(points)])
    )
    assert any("2 pieces" in note and "six rigid modes" in note for note in mesh.notes)


def test_a_seam_is_noted_and_merged_on_request():
    points, cells = hex_box(1)
    twice = np.vstack([points, points + np.array([1.0 + 1e-12, 0.0, 0.0])])
    both = np.vstack([cells, cells + 8])
    mesh = source_from_arrays(twice, both, kind="hexahedron")
    assert any("8 nodes share their place" in n and "--merge" in n for n in mesh.notes)
    assert any("2 pieces" in note for note in mesh.notes)
    merged = source_from_arrays(twice, both, kind="hexahedron", merge=1e-6)
    assert len(merged.points) == 12
    assert any("4 nodes were merged" in note for note in merged.notes)
    assert not any("pieces" in note for note in merged.notes)
    assert corner_volume(merged) == pytest.approx(2.0)
    # The earlier node stays.
    assert set(merged.node_numbers) >= set(range(1, 9))


@pytest.mark.parametrize("merge", [0.0, -1.0, np.nan, np.inf, 0.5, "small", True])
def test_a_merging_distance_must_be_sensible(merge):
    points, cells = hex_box(2)
    with pytest.raises(MeshError, match=r"--merge \(merge=\) must be"):
        source_from_arrays(points, cells, kind="hexahedron", merge=merge)


def test_repeated_cells_are_dropped():
    points, cells = tet_box(1)
    mesh = source_from_arrays(points, np.vstack([cells, cells[2:4, [1, 2, 0, 3]]]))
    np.testing.assert_array_equal(mesh.cells, cells)
    assert any("2 cells repeat" in note for note in mesh.notes)


def test_flat_cells_are_found_at_any_scale_and_place():
    points, cells = tet_box(1)
    for scale, shift in ((1e-6, 0.0), (1.0, 1e4), (1e6, 0.0)):
        sound = scale * points + shift
        assert len(source_from_arrays(sound, cells).cells) == len(cells)
        thin = sound * [1.0, 1.0, 0.0] + shift
        with pytest.raises(MeshError, match="have no volume"):
            source_from_arrays(thin, cells)
    # A thousandth of its length is thin, but a volume.
    assert len(source_from_arrays(points * [1.0, 1.0, 1e-4], cells).cells) == len(cells)


def fold_hexahedron(points, cells):
    points = points.copy()
    points[cells[0, 6]] = [-0.5, -0.5, -0.5]
    return points


@pytest.mark.parametrize(
    ("change", "kind", "nodes", "words"),
    [
        (fold_hexahedron, "hexahedron", 8, ["7 of 8 cells are folded", "worst cell", "re-mesh"]),
        (lambda p, c: p[::-1] * [1, np.nan, 1], "tetrahedron", 4, ["not finite", "node 1"]),
        (lambda p, c: p * [1, np.inf, 1], "tetrahedron", 4, ["not finite", "first node"]),
        (lambda p, c: p * 0.0, "tetrahedron", 4, ["no volume", "cell 1 at"]),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_coordinates_that_cannot_be_used(change, kind, nodes, words):
    points, cells = body(kind, nodes)
    with pytest.raises(MeshError) as error:
        source_from_arrays(change(points, cells), cells, kind=kind)
    for word in words:
        assert word in str(error.value)


def test_a_curved_tetrahedron_that_folds_is_refused():
    points, cells = body("tetrahedron", 10, n=1)
    middle = cells[0, 4]
    points[middle] = points[cells[0, 3]]
    points[middle] += [0.3, 0.3, 0.3]
    with pytest.raises(MeshError, match="folded"):
        source_from_arrays(points, cells)


@pytest.mark.parametrize(
    ("points", "cells", "kind", "words"),
    [
        (np.zeros((4, 2)), [[0, 1, 2, 3]], "tetrahedron", ["shape (4, 2)", "(n, 3)"]),
        (np.zeros((0, 3)), [[0, 1, 2, 3]], "tetrahedron", ["shape (0, 3)"]),
        (np.eye(4, 3), [[0, 1, 2]], "tetrahedron", ["shape (1, 3)", "(m, 4)"]),
        (np.eye(4, 3), np.zeros((0, 4), int), "tetrahedron", ["shape (0, 4)", "m > 0"]),
        (np.eye(4, 3), [[0, 1, 2, 3]], "wedge", ["'wedge'", "'hexahedron'"]),
        (np.eye(4, 3), [[0, 1, 2, 4]], "tetrahedron", ["node row 4", "0 to 3"]),
        (np.eye(4, 3), [[0, 1, 2, -1]], "tetrahedron", ["node row -1", "0 to 3"]),
        (np.eye(4, 3), [[0, 1, 2, 2]], "tetrahedron", ["same node twice", "cell 1"]),
        (np.eye(4, 3), [[0, 1, 2, 3.5]], "tetrahedron", ["cells", "integers"]),
        ("abc", [[0, 1, 2, 3]], "tetrahedron", ["points", "float64"]),
        ([[1, 2, 3], [1]], [[0, 1, 2, 3]], "tetrahedron", ["points", "rectangular"]),
    ],
)
def test_arrays_that_are_no_mesh(points, cells, kind, words):
    with pytest.raises(MeshError) as error:
        source_from_arrays(points, cells, kind=kind)
    for word in words:
        assert word in str(error.value)


def test_the_callers_arrays_are_neither_changed_nor_shared():
    points, cells = tet_box(1)
    cells[0] = cells[0][[1, 0, 2, 3]]
    given_points, given_cells = points.copy(), cells.copy()
    mesh = source_from_arrays(points, cells)
    points[:] = 7.0
    assert not np.any(mesh.points == 7.0)
    np.testing.assert_array_equal(cells, given_cells)
    np.testing.assert_array_equal(mesh.points, given_points)
    with pytest.raises(ValueError, match="read-only"):
        mesh.points[0] = 0.0
