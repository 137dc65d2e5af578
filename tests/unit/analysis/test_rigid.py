import numpy as np
import pytest
from modal_bodies import box_arrays, joined, moved

from fenics_defo.analysis.rigid import blocks, rigid_motions, strainless_motions, supports


def held_at(points, condition, components="xyz"):
    held = np.zeros(points.shape, bool)
    held[:, ["xyz".index(c) for c in components]] = condition(points)[:, None]
    return held


def motions_of(arrays, held=None):
    points, cells = arrays
    held = np.zeros(points.shape, bool) if held is None else held
    return strainless_motions(points, cells, cells.shape[1], held)


def strain_rates(fields, arrays):
    """Rate at which each edge of each cell changes its length, relative to it."""
    points, cells = arrays
    a, b = np.array([(i, j) for i in range(cells.shape[1]) for j in range(i)]).T
    edge = points[cells[:, a]] - points[cells[:, b]]
    relative = fields[:, cells[:, a]] - fields[:, cells[:, b]]
    return (relative * edge).sum(axis=-1) / (edge**2).sum(axis=-1)


def test_rigid_motions_keep_all_distances_to_first_order():
    points = np.random.default_rng(1).standard_normal((20, 3))
    motions = rigid_motions(points, np.array([1.0, -2.0, 3.0]))
    assert np.linalg.matrix_rank(motions.reshape(6, -1)) == 6
    edge = points[:, None] - points
    relative = motions[:, :, None] - motions[:, None]
    assert (relative * edge).sum(axis=-1) == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize(
    ("rotation", "expected"), [(3, [0, 0, 1]), (4, [0, 0, 0]), (5, [-1, 0, 0])]
)
def test_rotations_follow_the_right_hand(rotation, expected):
    motion = rigid_motions(np.array([[0.0, 1.0, 0.0]]), np.zeros(3))[rotation]
    assert motion.tolist() == [expected]


@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
def test_blocks_hang_together_by_faces(kind):
    part = box_arrays((2, 1, 1), kind=kind)
    assert blocks(part[1])[0] == 1
    for shift, number in [((2.0, 0.0, 0.0), 2), ((1.0, 1.0, 0.0), 2), ((1.0, 1.0, 1.0), 2)]:
        _, cells = joined(part, moved(part, *shift))
        found, labels = blocks(cells)
        assert found == number
        assert np.bincount(labels).tolist() == [len(part[1])] * 2
    assert blocks(joined(part, moved(part, 1.0, 0.0, 0.0))[1])[0] == 1


@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize(
    ("shift", "number"),
    [((1.0, 0.0, 0.0), 6), ((1.0, 1.0, 0.0), 7), ((1.0, 1.0, 1.0), 9), ((3.0, 0.0, 0.0), 12)],
)
def test_two_parts_that_share_a_face_an_edge_a_node_or_nothing(kind, shift, number):
    part = box_arrays((1, 1, 1), kind=kind)
    arrays = joined(part, moved(part, *shift))
    fields = motions_of(arrays)
    assert len(fields) == number
    assert np.linalg.matrix_rank(fields.reshape(number, -1)) == number
    assert strain_rates(fields, arrays) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("condition", "components", "number"),
    [
        (lambda p: p[:, 0] == 0.0, "xyz", 0),
        (lambda p: (p[:, 0] == 0.0) & (p[:, 2] == 0.0), "xyz", 1),
        (lambda p: p.sum(axis=1) == 0.0, "xyz", 3),
        (lambda p: p[:, 2] == 0.0, "z", 3),
        (lambda p: p[:, 0] < 2.0, "yz", 1),
        (lambda p: p[:, 0] > 9.0, "xyz", 6),
    ],
)
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-6, 0.0), (1e4, 0.0), (1.0, 1e4)])
def test_what_constraints_leave(condition, components, number, scale, offset):
    points, cells = box_arrays((3, 2, 2), (1.0, 0.3, 0.2))
    held = held_at(points, condition, components)
    arrays = (points * scale + offset, cells)
    fields = motions_of(arrays, held)
    assert len(fields) == number
    assert (fields[:, held] == 0.0).all()
    assert strain_rates(fields * scale, arrays) == pytest.approx(0.0, abs=1e-9)


def test_a_chain_of_hinged_blocks_swings_like_one():
    part = box_arrays((1, 1, 1))
    chain = joined(*(moved(part, 1.0 * i, float(i % 2), 0.0) for i in range(4)))
    assert len(motions_of(chain)) == 6 + 3
    held = held_at(chain[0], lambda p: p[:, 0] == 0.0)
    assert len(motions_of(chain, held)) == 3


def test_a_short_lever_still_holds():
    points, cells = box_arrays((100, 1, 1), (1.0, 1e-4, 1e-4))
    held = held_at(points, lambda p: p[:, 0] == 0.0)
    assert len(motions_of((points, cells), held)) == 0


def test_supports_hold_every_motion():
    arrays = box_arrays((3, 2, 2), (1.0, 0.3, 0.2))
    fields = motions_of(arrays)
    free = np.ones(arrays[0].shape, bool)
    free[::2] = False
    chosen = supports(fields, free)
    assert chosen.sum() == 6
    assert not chosen[~free].any()
    singular = np.linalg.svd(fields[:, chosen], compute_uv=False)
    assert singular[-1] > 0.05 * singular[0]
    assert supports(fields[:0], free).sum() == 0
