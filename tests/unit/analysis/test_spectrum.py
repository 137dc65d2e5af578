import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.analysis.spectrum import align_clusters, cluster_end, quadratic_fields, signs


@pytest.mark.parametrize(
    ("values", "count", "end"),
    [
        ([1.0, 2.0, 3.0], 1, 1),
        ([1.0, 1.0, 3.0], 1, 2),
        ([1.0, 1.0001, 1.0002, 3.0], 1, 3),  # a chain of neighbours
        ([1.0, 1.01, 3.0], 1, 1),
        ([0.0, 0.0, 0.0, 1.0], 2, 3),
        ([1.0, 2.0, 2.0], 2, 3),
        ([1.0, 2.0], 2, 2),
    ],
)
def test_no_cluster_is_cut(values, count, end):
    assert cluster_end(np.array(values), count, rtol=2e-4) == end


@given(st.integers(2, 6), st.integers(1, 12), st.integers(0, 10_000))
def test_alignment_undoes_any_rotation_of_a_cluster(size, fields, seed):
    rng = np.random.default_rng(seed)
    values = np.array([1.0, *[2.0] * size, 5.0])
    projections = rng.standard_normal((size + 2, fields))
    apart = np.linalg.qr(rng.standard_normal((size, size)))[0][:, :fields]
    projections[1:-1, : apart.shape[1]] = apart + 0.2 * np.roll(apart, 1, axis=1)
    mixed = np.eye(size + 2)
    mixed[1:-1, 1:-1] = np.linalg.qr(rng.standard_normal((size, size)))[0]
    rtol = np.full(size + 2, 1e-9)
    rotation = align_clusters(values, projections, rtol=rtol)
    other = align_clusters(values, mixed.T @ projections, rtol=rtol)
    assert rotation.T @ rotation == pytest.approx(np.eye(size + 2), abs=1e-12)
    assert rotation[0].tolist() == [1.0] + [0.0] * (size + 1)
    seen = 1 + min(size, fields)  # what no field sees is not unique
    assert (mixed @ other)[:, :seen] == pytest.approx(rotation[:, :seen], abs=1e-6)


def test_the_first_field_goes_to_the_first_vector_alone():
    projections = np.array([[3.0, 1.0], [4.0, 2.0]])
    aligned = align_clusters(np.ones(2), projections, rtol=np.full(2, 1e-9)).T @ projections
    assert aligned[0, 0] == pytest.approx(5.0)
    assert aligned[1, 0] == pytest.approx(0.0, abs=1e-14)


def test_clusters_that_no_field_sees_stay():
    rotation = align_clusters(np.ones(3), np.full((3, 4), 1e-15), rtol=np.full(3, 1e-9))
    assert rotation.tolist() == np.eye(3).tolist()


def test_tiny_masses_do_not_spoil_the_rotation():
    projections = np.array([[1e-7, 0.0], [0.0, 1e-12]])
    rotation = align_clusters(np.ones(2), projections, rtol=np.full(2, 1e-9))
    assert rotation.T @ rotation == pytest.approx(np.eye(2), abs=1e-14)


@given(st.integers(0, 10_000))
def test_the_largest_component_becomes_positive(seed):
    shapes = np.random.default_rng(seed).standard_normal((4, 5, 3))
    sign = signs(shapes)
    assert (np.abs(sign) == 1.0).all()
    flat = (shapes * sign[:, None, None]).reshape(4, -1)
    assert (flat.max(axis=1) == np.abs(flat).max(axis=1)).all()
    assert (signs(-shapes) == -sign).all()


def test_round_off_does_not_choose_between_equal_components():
    shape = np.zeros((1, 3, 3))
    shape[0, 0, 1], shape[0, 2, 1] = -1.0, 1.0 + 1e-9
    assert signs(shape).tolist() == [-1.0]


def test_the_fields_are_all_of_second_degree_and_begin_with_the_rigid_motions():
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 3))
    fields = quadratic_fields(points).reshape(30, -1)
    assert np.linalg.matrix_rank(fields) == 30
    for axis in range(3):
        assert fields[3 + axis].reshape(-1, 3) == pytest.approx(
            np.cross(np.eye(3)[axis], points), abs=1e-15
        )
    x, y, z = points.T
    some = np.stack([x * y + 2.0, z * z - x, 3.0 * y], axis=1).ravel()
    assert np.linalg.lstsq(fields.T, some, rcond=None)[1] == pytest.approx(0.0, abs=1e-20)
