"""Points of a body as weighted means of nodes."""

import numpy as np
import pytest
from modal_bodies import box_arrays

from fenics_defo.analysis.point_location import locate_node, locate_point
from fenics_defo.energy import LinearElastic
from fenics_defo.errors import LoadError
from fenics_defo.fem import Solid, build_mesh

MATERIAL = LinearElastic(young=1.0, poisson=0.3, density=1.0)


def body(kind, order):
    """Cells that are no parallelepipeds."""
    points, cells = box_arrays((2, 2, 2), (1.0, 0.8, 0.6), kind=kind)
    x, y, z = points.T
    points = np.column_stack([x + 0.1 * y * z, y * (1.0 - 0.2 * x), z + 0.2 * x * y])
    return Solid(build_mesh(points, cells, kind=kind), MATERIAL, order=order)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
def test_linear_fields_are_met_anywhere(kind, order):
    solid = body(kind, order)
    rng = np.random.default_rng(1)
    corners = solid.points[solid.cells[:, : 4 if kind == "tetrahedron" else 8]]
    inside = corners.mean(axis=1)  # of each cell
    on_surface = solid.points[rng.integers(len(solid.points), size=5)]
    for point in [*inside, *on_surface, 0.7 * inside[0] + 0.3 * inside[1]]:
        place = locate_point(solid, point, what="it")
        assert place.weights.sum() == pytest.approx(1.0, abs=1e-12)
        assert place.weights @ solid.points[place.rows] == pytest.approx(point, abs=1e-10)


def test_quadratic_fields_are_met_by_quadratic_cells():
    solid = body("tetrahedron", 2)

    def field(x):
        return x[..., 0] ** 2 - x[..., 1] * x[..., 2]

    point = solid.points[solid.cells[5, :4]].T @ [0.1, 0.2, 0.3, 0.4]
    place = locate_point(solid, point, what="it")
    assert place.weights @ field(solid.points[place.rows]) == pytest.approx(field(point), rel=1e-10)


def test_a_node_is_itself_and_others_are_refused():
    solid = body("hexahedron", 1)
    place = locate_node(solid, 3, what="it")
    assert (place.rows, place.weights) == ([3], [1.0])
    for wrong in (-1, len(solid.points), 1.5, True):
        with pytest.raises(LoadError, match="node of it"):
            locate_node(solid, wrong, what="it")
    with pytest.raises(LoadError, match=r"outside of the body; the nearest node is at \(0, 0, 0\)"):
        locate_point(solid, np.array([-1.0, -1.0, -1.0]), what="it")
