"""Every body of meshes/: groups cover what they say, volumes are right, cells are sound."""

import math
from collections.abc import Callable
from typing import Any

import gmsh
import numpy as np
import pytest
from numpy.typing import NDArray

from meshes import (
    basket,
    bent_beam,
    bridge,
    cantilever,
    heart,
    l_bracket,
    modelling,
    scripting,
    sphere,
    spoon,
    tuning_fork,
    two_material_beam,
)

type Array = NDArray[np.float64]

COARSE: list[tuple[Callable[..., None], dict[str, Any], set[str]]] = [
    (cantilever.cantilever, {"size": 0.1}, {"body", "clamped", "tip", "top"}),
    (
        two_material_beam.two_material_beam,
        {"size": 0.1},
        {"steel", "aluminium", "clamped", "tip", "interface"},
    ),
    (bent_beam.bent_beam, {"size": 0.1}, {"body", "clamped", "tip"}),
    (sphere.sphere, {"size": 0.5}, {"body", "surface"}),
    (tuning_fork.tuning_fork, {"size": 0.003, "order": 1}, {"body", "stem_end", "prong_tips"}),
    (spoon.spoon, {"size": 0.005}, {"body", "handle_end", "bowl"}),
    (l_bracket.l_bracket, {"size": 0.01}, {"body", "bolts", "load_face"}),
]


def measure(dimension: int, group: str) -> float:
    """Area [m2] or volume [m3] of a group of the current model, from its cells' Jacobians."""
    (tag,) = (t for d, t in gmsh.model.getPhysicalGroups(dimension) if name_of(d, t) == group)
    total = 0.0
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
        for kind in gmsh.model.mesh.getElementTypes(dimension, entity):
            points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss6")
            _, determinants, _ = gmsh.model.mesh.getJacobians(kind, points, entity)
            total += float((np.abs(determinants.reshape(-1, len(weights))) @ weights).sum())
    return total


def name_of(dimension: int, tag: int) -> str:
    return str(gmsh.model.getPhysicalName(dimension, tag))


def corners(group: str) -> Array:
    """Nodes (n, 3) of the faces of a group of the current model."""
    (tag,) = (t for d, t in gmsh.model.getPhysicalGroups(2) if name_of(d, t) == group)
    _, coordinates = gmsh.model.mesh.getNodesForPhysicalGroup(2, tag)
    return np.asarray(coordinates).reshape(-1, 3)


@pytest.mark.parametrize(
    ("body", "options", "groups"), COARSE, ids=[body.__name__ for body, _, _ in COARSE]
)
def test_body_is_sound(
    body: Callable[..., None], options: dict[str, Any], groups: set[str]
) -> None:
    with scripting.built(body, **options) as summary:
        assert_sound(summary, groups)


def assert_sound(summary: scripting.MeshSummary, groups: set[str]) -> None:
    """The current model is one conforming piece of good tetrahedra and has these groups."""
    assert set(summary.groups) == groups
    assert summary.quality > 0.1
    assert summary.nodes < 5000
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    assert list(kinds) == [4]  # tetrahedra of four nodes
    cells = np.concatenate(nodes).reshape(-1, 4)
    assert one_piece(cells)
    # Conforming: a triangle belongs to two cells, or to one and to the body's boundary.
    triangles = [gmsh.model.mesh.getElements(2, face)[2][0] for face in modelling.boundary_faces()]
    outer = np.sort(np.concatenate(triangles).reshape(-1, 3), axis=1)
    every, count = np.unique(sorted_faces(cells), axis=0, return_counts=True)
    assert set(count) == {1, 2}
    np.testing.assert_array_equal(every[count == 1], np.unique(outer, axis=0))


def sorted_faces(cells: NDArray[Any]) -> NDArray[Any]:
    local = ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])
    return np.sort(np.concatenate([cells[:, index] for index in local]), axis=1)


def one_piece(cells: NDArray[Any]) -> bool:
    """True if every cell can be reached from the first through shared nodes."""
    _, flat = np.unique(cells, return_inverse=True)
    numbered = flat.reshape(cells.shape)
    label = np.arange(numbered.max() + 1)
    while True:
        lowest = label[numbered].min(axis=1)
        new = label.copy()
        np.minimum.at(new, numbered.ravel(), np.repeat(lowest, 4))
        if np.array_equal(new, label):
            return bool((label == 0).all())
        label = new


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize("order", [1, 2])
def test_regular_beams_have_exact_measures(cell: str, order: int) -> None:
    box = {"length": 0.6, "width": 0.2, "height": 0.3}
    with scripting.built(cantilever.cantilever, size=0.1, order=order, cell=cell, **box) as summary:
        boxes = 6 * 2 * 3
        assert summary.cells == (boxes if cell == "hexahedron" else 6 * boxes)
        assert summary.nodes == math.prod(order * n + 1 for n in (6, 2, 3))
        assert measure(3, "body") == pytest.approx(0.036, rel=1e-12)
        assert measure(2, "clamped") == pytest.approx(0.06, rel=1e-12)
        assert measure(2, "top") == pytest.approx(0.12, rel=1e-12)
        np.testing.assert_allclose(corners("clamped")[:, 0], 0.0, atol=1e-12)
        np.testing.assert_allclose(corners("tip")[:, 0], 0.6, atol=1e-12)


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_two_materials_share_their_interface(cell: str) -> None:
    options = {"steel": 0.3, "aluminium": 0.5, "size": 0.1, "cell": cell}
    with scripting.built(two_material_beam.two_material_beam, **options) as summary:
        assert measure(3, "steel") == pytest.approx(0.003, rel=1e-12)
        assert measure(3, "aluminium") == pytest.approx(0.005, rel=1e-12)
        assert measure(2, "interface") == pytest.approx(0.01, rel=1e-12)
        np.testing.assert_allclose(corners("interface")[:, 0], 0.3, atol=1e-12)
        assert summary.nodes == 9 * 2 * 2  # those of one beam: none is there twice


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize(("order", "rate"), [(1, 2.0), (2, 4.0)])
def test_volume_of_the_bent_beam_converges(cell: str, order: int, rate: float) -> None:
    exact = math.pi / 2 * 0.5 * 0.1 * 0.1  # Pappus
    errors = []
    for size in (0.1, 0.05):
        with scripting.built(bent_beam.bent_beam, size=size, order=order, cell=cell):
            errors.append(abs(measure(3, "body") / exact - 1.0))
            assert measure(2, "tip") == pytest.approx(0.01, rel=1e-9)
            np.testing.assert_allclose(corners("tip")[:, 2], 0.5, atol=1e-12)
    # The arc is cut into 9 and then 18 parts.
    assert math.log2(errors[0] / errors[1]) == pytest.approx(rate, abs=0.1)


def test_second_order_nodes_lie_on_the_sphere() -> None:
    with scripting.built(sphere.sphere, size=0.5, order=2, radius=2.0):
        radii = np.linalg.norm(corners("surface"), axis=1)
        kinds, _, nodes = gmsh.model.mesh.getElements(2)
        assert list(kinds) == [9]  # triangles of six nodes
        assert len(radii) == len(np.unique(nodes[0]))
    np.testing.assert_allclose(radii, 2.0, rtol=1e-9)


@pytest.mark.parametrize(("order", "rate", "slack"), [(1, 2.0, 0.3), (2, 4.0, 0.6)])
def test_volume_of_the_ball_converges(order: int, rate: float, slack: float) -> None:
    errors = []
    for size in (0.4, 0.2):
        with scripting.built(sphere.sphere, size=size, order=order):
            errors.append(abs(measure(3, "body") / (4.0 / 3.0 * math.pi) - 1.0))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(rate, abs=slack)


def test_measures_of_the_fork() -> None:
    area = math.pi * tuning_fork.BAR**2
    with scripting.built(tuning_fork.tuning_fork, size=0.003, order=2):
        assert measure(2, "prong_tips") == pytest.approx(2.0 * area, rel=2e-3)
        assert measure(2, "stem_end") == pytest.approx(
            math.pi * tuning_fork.STEM_RADIUS**2, rel=2e-3
        )
        # The bar is its section times its centre line; the stem begins inside the bend.
        bar = area * (2.0 * tuning_fork.PRONG + math.pi * tuning_fork.BEND)
        stem = math.pi * tuning_fork.STEM_RADIUS**2 * tuning_fork.STEM
        volume = measure(3, "body")
        assert bar + stem < volume < 1.01 * (bar + stem)
        assert corners("prong_tips")[:, 2].min() == pytest.approx(tuning_fork.PRONG)


def test_groups_of_the_bridge() -> None:
    with scripting.built(bridge.bridge, size=1.0) as summary:
        assert_sound(summary, {"body", "abutments", "deck"})
        between_kerbs = bridge.DECK_WIDTH - 2.0 * bridge.KERB
        assert measure(2, "deck") == pytest.approx(bridge.DECK_LENGTH * between_kerbs, rel=1e-9)
        deck_end = bridge.DECK_WIDTH * bridge.DECK_DEPTH + 2.0 * bridge.KERB**2
        springing = bridge.RIB_WIDTH * bridge.RIB_DEPTH
        abutments = 2.0 * deck_end + 4.0 * springing
        assert measure(2, "abutments") == pytest.approx(abutments, rel=1e-9)
        assert abs(corners("abutments")[:, 0]).min() > bridge.SPAN / 2 - bridge.RIB_DEPTH


def test_the_spoon_has_its_dimensions() -> None:
    # Along a normal the pressed sheet keeps its thickness: 2 mm in the bowl, 3 mm at the neck.
    x = np.array([0.01, spoon.BOWL_CENTRE, spoon.HANDLE[1, 0]])
    flat = np.stack([x, np.zeros(3), np.full(3, spoon.SHEET / 2)], axis=1)
    thickness = np.linalg.norm(spoon.press(flat) - spoon.press(flat * [1, 1, -1]), axis=1)
    np.testing.assert_allclose(thickness, [2.0e-3, 2.0e-3, 3.0e-3], rtol=0.08)
    # The bowl is some 9 mm deep, from its rim on either side to its lowest point.
    side = spoon.press(np.array([[spoon.BOWL_CENTRE, y, 0.0] for y in (0.0, spoon.BOWL[2])]))
    assert np.diff(side[:, 2]) == pytest.approx(9.0e-3, rel=0.05)
    with scripting.built(spoon.spoon, size=0.004):
        points = corners("bowl")
        assert np.ptp(points[:, 0]) == pytest.approx(spoon.NECK, rel=0.05)
        assert np.ptp(points[:, 1]) == pytest.approx(2.0 * spoon.BOWL[2], rel=0.05)
        assert corners("handle_end")[:, 0].min() > spoon.HELD_FROM - spoon.SHEET
        assert corners("handle_end")[:, 0].max() == pytest.approx(spoon.LENGTH, rel=0.01)


def test_slopes_of_the_spoon_are_those_of_its_height() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.uniform(0.005, 0.195, 50), rng.uniform(-0.015, 0.015, 50)
    step = 1.0e-6
    _, slope_x, slope_y = spoon._middle_surface(x, y)
    ahead, behind = (spoon._middle_surface(x + s, y)[0] for s in (step, -step))
    left, right = (spoon._middle_surface(x, y + s)[0] for s in (step, -step))
    np.testing.assert_allclose(slope_x, (ahead - behind) / (2.0 * step), atol=1e-6)
    np.testing.assert_allclose(slope_y, (left - right) / (2.0 * step), atol=1e-6)


def test_cavities_of_the_heart() -> None:
    with scripting.built(heart.heart, size=0.005) as summary:
        assert_sound(summary, {"myocardium", "base", "endocardium", "epicardium"})
        np.testing.assert_allclose(corners("base")[:, 2], 0.0, atol=1e-9)
        inside = corners("endocardium")
        # The published volumes of the cavities [m3], by the flux of (0, 0, z) out of them.
        assert cavity_volume() == pytest.approx(36.98e-6 + 51.21e-6, rel=0.03)
        # The septum is endocardium: nodes of the left ventricle's outside on the right one's side.
        level = np.sum((inside / heart.LEFT) ** 2, axis=1)
        assert (abs(level - 1.0) < 1e-4).sum() > 20
        assert corners("epicardium")[:, 2].min() == pytest.approx(-heart.LEFT[2], rel=1e-3)


def cavity_volume() -> float:
    """Volume [m3] between the endocardium and the plane z = 0: the flux of (0, 0, z) into it."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    where = np.empty((tags.max() + 1, 3))
    where[tags] = coordinates.reshape(-1, 3)
    cells = gmsh.model.mesh.getElements(3)[2][0].reshape(-1, 4)
    (group,) = (t for d, t in gmsh.model.getPhysicalGroups(2) if name_of(d, t) == "endocardium")
    faces = gmsh.model.getEntitiesForPhysicalGroup(2, group)
    triangles = np.concatenate([gmsh.model.mesh.getElements(2, face)[2][0] for face in faces])
    ours = np.isin(keys(sorted_faces(cells)), keys(np.sort(triangles.reshape(-1, 3), axis=1)))
    a, b, c = where[sorted_faces(cells)[ours]].transpose(1, 0, 2)
    # The normals of the triangles are turned away from the middle of the cell behind each.
    behind = np.tile(where[cells].mean(axis=1), (4, 1))[ours]
    normal = np.cross(b - a, c - a) / 2.0
    out = np.sign(np.sum((a - behind) * normal, axis=1))
    return float(-(out * normal[:, 2]) @ (a + b + c)[:, 2] / 3.0)


def keys(triangles: NDArray[Any]) -> NDArray[np.int64]:
    """One number for each triple (n, 3) of node numbers below two million."""
    return triangles.astype(np.int64) @ np.array([1 << 42, 1 << 21, 1])


def test_groups_of_the_basket() -> None:
    with scripting.built(basket.basket, size=0.02) as summary:
        assert_sound(summary, {"body", "rim", "bottom"})
        outer, inner = basket.RIM_RADIUS + basket.LIP, basket.RIM_RADIUS - basket.WALL
        ring = math.pi * (outer**2 - inner**2)
        assert measure(2, "rim") == pytest.approx(ring, rel=0.01)
        disk = math.pi * basket.BOTTOM_RADIUS**2
        assert measure(2, "bottom") == pytest.approx(disk, rel=0.02)
        np.testing.assert_allclose(corners("bottom")[:, 2], 0.0, atol=1e-12)


@pytest.mark.parametrize("fillet", [0.004, 0.02])
def test_volume_of_the_bracket(fillet: float) -> None:
    leg, sheet = l_bracket.LEG, l_bracket.SHEET
    section = leg**2 - (leg - sheet) ** 2 + fillet**2 * (1.0 - math.pi / 4)
    holes = 2.0 * math.pi * l_bracket.BOLT**2 * sheet
    with scripting.built(l_bracket.l_bracket, size=0.008, order=2, fillet=fillet):
        assert measure(3, "body") == pytest.approx(section * l_bracket.WIDTH - holes, rel=1e-4)
        walls = 2.0 * 2.0 * math.pi * l_bracket.BOLT * sheet
        assert measure(2, "bolts") == pytest.approx(walls, rel=1e-3)
        top = (leg - sheet - fillet) * l_bracket.WIDTH
        assert measure(2, "load_face") == pytest.approx(top, rel=1e-9)
