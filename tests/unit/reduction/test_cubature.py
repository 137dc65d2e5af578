"""Cubature: exact with all points, accurate on poses it has not seen, the same on each run."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.optimize import nnls

from fenics_defo import energy
from fenics_defo.errors import DefoError, MaterialError
from fenics_defo.reduction.cubature.candidates import candidates, stresses, total_force
from fenics_defo.reduction.cubature.nonnegative import GrowingLeastSquares
from fenics_defo.reduction.cubature.poses import PoseSampler, rest_stiffness
from fenics_defo.reduction.cubature.selection import Curve, Selection
from fenics_defo.reduction.cubature.training import assembled, train_cubature
from fenics_defo.reduction.direct_force import DirectForce
from tests.unit.reduction.cubature_bodies import LAWS, TWO, body, shapes_of

ELEMENTS = [("tetrahedron", 1), ("tetrahedron", 2), ("hexahedron", 1), ("hexahedron", 2)]


def with_all_points(solid, shapes):
    groups = candidates(solid, shapes)
    numbers = np.concatenate([points.numbers for points in groups])
    weights = np.concatenate([points.weights for points in groups])
    order = np.argsort(numbers)
    everything = Selection(
        numbers[order], weights[order], Curve(np.zeros(0), np.zeros(0), np.zeros(0)), True
    )
    return assembled(groups, everything, solid)


def poses(size, count=3, scale=0.05):
    return scale * np.random.default_rng(2).standard_normal((count, size))


@pytest.mark.parametrize("law", LAWS)
def test_every_point_at_its_own_weight_is_the_assembled_force(law):
    solid = body(law, cells=(2, 1, 1))
    shapes = shapes_of(solid, 5)
    own, direct = with_all_points(solid, shapes), DirectForce(solid, shapes)
    for q in poses(5):
        for found, wanted in (
            (own.force(q), direct.force(q)),
            (own.stiffness(q), direct.stiffness(q)),
            (own.energy(q), direct.energy(q)),
        ):
            assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize(("kind", "order"), ELEMENTS)
def test_any_element_and_two_materials_are_summed_exactly(kind, order):
    solid = body(TWO, kind=kind, order=order, cells=(2, 1, 1))
    shapes = shapes_of(solid, 4)
    own, direct = with_all_points(solid, shapes), DirectForce(solid, shapes)
    assert len(own.laws) == 2
    q = poses(4)[0]
    wanted = direct.force(q)
    assert np.abs(own.force(q) - wanted).max() <= 1e-12 * np.abs(wanted).max()


@pytest.mark.parametrize("method", ["greedy", "ecsw"])
def test_training_keeps_its_promise_on_poses_it_has_not_seen(method):
    solid = body()
    shapes = shapes_of(solid, 6)
    tolerance = 0.02
    found = train_cubature(solid, shapes, tolerance=tolerance, method=method)
    assert found.training_error <= tolerance
    assert found.held_out_error <= 2 * tolerance
    assert found.advice is None
    assert found.points < found.candidates / 2
    direct = DirectForce(solid, shapes)
    sampler = PoseSampler(candidates(solid, shapes), solid.comm, np.random.default_rng(77))
    cloud = sampler.statics(10, 0.2)
    wanted = direct.force(cloud.coordinates)
    apart = np.linalg.norm(found.force.force(cloud.coordinates) - wanted, axis=1)
    errors = apart / np.linalg.norm(wanted, axis=1)
    assert np.sqrt((errors**2).mean()) <= 2.5 * tolerance


def test_errors_fall_with_the_points_and_the_curve_tells_so():
    solid = body()
    shapes = shapes_of(solid, 6)
    seen = []
    found = train_cubature(
        solid, shapes, tolerance=1e-6, most=24, observe=lambda *row: seen.append(row)
    )
    assert found.points == 24
    curve = found.curve
    assert seen == list(zip(curve.points, curve.training, curve.held_out, strict=True))
    assert (np.diff(found.curve.training) <= 1e-12).all()
    few, many = (found.curve.held_out[found.curve.points >= n][0] for n in (8, 24))
    assert many < 0.5 * few
    assert "more points" in found.advice


def test_a_seed_gives_the_same_law_and_another_seed_another():
    solid = body(cells=(4, 1, 1))
    shapes = shapes_of(solid, 4)
    one, again, other = (
        train_cubature(solid, shapes, tolerance=0.1, seed=seed).force for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.weights, again.weights)
    np.testing.assert_array_equal(one.gradients, again.gradients)
    assert one.weights.shape != other.weights.shape or (one.weights != other.weights).any()


def test_the_stiffness_at_rest_can_be_kept():
    solid = body()
    shapes = shapes_of(solid, 6)
    options = {"tolerance": 0.2, "seed": 3}
    plain = train_cubature(solid, shapes, **options)
    kept = train_cubature(solid, shapes, **options, keep_rest_stiffness=True)
    exact = DirectForce(solid, shapes).stiffness(np.zeros(6))
    scale = np.abs(exact).max()
    assert np.abs(plain.force.stiffness(np.zeros(6)) - exact).max() > 1e-3 * scale
    assert np.abs(kept.force.stiffness(np.zeros(6)) - exact).max() < 1e-11 * scale
    assert plain.rest_error > 1e-3
    # The frequencies of the reduced law at rest, by an independent route.
    ratios = np.linalg.eigvals(np.linalg.solve(exact, plain.force.stiffness(np.zeros(6))))
    assert plain.rest_error == pytest.approx(np.abs(np.sqrt(ratios.real) - 1).max(), rel=1e-6)


def test_poses_of_ones_own_train_and_judge():
    solid = body()
    shapes = shapes_of(solid, 4)
    given = poses(4, 40, 0.02)
    found = train_cubature(solid, shapes, poses=given, tolerance=0.05)
    assert found.kind == "given"
    assert len(found.poses) == 32
    assert found.held_out_error < 0.2


def test_an_interruption_keeps_the_best_set_reached():
    solid = body()
    shapes = shapes_of(solid, 4)

    def stop(points, training, held_out):
        if points == 5:
            raise KeyboardInterrupt

    found = train_cubature(solid, shapes, tolerance=1e-6, observe=stop)
    assert found.points == 5
    assert found.advice is not None


def test_drawn_poses_have_the_strains_that_were_asked_for_and_no_inverted_cell():
    solid = body()
    shapes = shapes_of(solid, 6)
    groups = candidates(solid, shapes)
    sampler = PoseSampler(groups, solid.comm, np.random.default_rng(0))
    for cloud in (sampler.statics(30, 0.3), sampler.sampled(30, 0.3)):
        assert cloud.strains.max() <= 0.3 * 1.05
        assert cloud.strains.max() > 0.1
        assert len(cloud.coordinates) == 30
        _, smallest = sampler._extremes(cloud.coordinates, groups)
        assert (smallest > 0).all()


def test_poses_that_turn_cells_inside_out_are_drawn_again_and_counted():
    solid = body()
    shapes = shapes_of(solid, 6)
    sampler = PoseSampler(candidates(solid, shapes), solid.comm, np.random.default_rng(0))
    assert sampler.sampled(40, 8.0).redrawn > 0


def test_the_sum_of_all_candidates_is_the_stiffness_and_force_of_the_body():
    solid = body("mooney-rivlin")
    shapes = shapes_of(solid, 4)
    groups, q = candidates(solid, shapes), poses(4)
    direct = DirectForce(solid, shapes)
    forces = total_force(groups, tuple(stresses(g, q) for g in groups), solid.comm)
    np.testing.assert_allclose(forces, direct.force(q), rtol=1e-11)
    exact = direct.stiffness(np.zeros(4))
    np.testing.assert_allclose(
        rest_stiffness(groups, solid.comm), exact, rtol=1e-10, atol=1e-11 * exact.max()
    )


@settings(max_examples=60, deadline=None)
@given(
    columns=hnp.arrays(float, (7, 12), elements=st.floats(-1, 1)),
    target=hnp.arrays(float, 12, elements=st.floats(-1, 1)),
)
def test_growing_least_squares_ends_where_no_weight_can_improve(columns, target):
    fit = GrowingLeastSquares(target)
    for key, column in enumerate(columns):
        fit.add([key], column[None])
    assert (fit.weights > 0).all()
    used = columns[fit.keys]
    # At the columns in use the residual has no part left, and it never grew.
    assert np.abs(used @ fit.residual).max(initial=0.0) <= 1e-6
    assert np.linalg.norm(fit.residual) <= np.linalg.norm(target) * (1 + 1e-12)
    if len(fit.keys) == len(columns):  # nothing has left: the bounded optimum
        assert np.linalg.norm(fit.residual) == pytest.approx(nnls(columns.T, target)[1], abs=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"strain": -1.0}, "strain"),
        ({"most": 0}, "most"),
        ({"method": "magic"}, "method"),
        ({"poses": "anything"}, "poses"),
        ({"poses": np.zeros((5, 3))}, "coordinates"),
        ({"poses": np.zeros((5, 4))}, "at rest"),
    ],
)
def test_bad_options_are_told_in_a_sentence(options, message):
    solid = body(cells=(2, 1, 1))
    with pytest.raises(DefoError, match=message):
        train_cubature(solid, shapes_of(solid, 4), **options)


def test_springs_have_no_points():
    springs = energy.MassSpring(young=1e5, density=1e3)
    solid = body(springs, cells=(2, 1, 1))
    with pytest.raises(MaterialError, match="MassSpring"):
        train_cubature(solid, shapes_of(solid, 3))
