"""Models with cubature: from a body to a file to a run, against the full simulation."""

import numpy as np
import pytest

from fenics_defo import analysis, reduction, runtime
from fenics_defo.errors import DefoError
from tests.unit.reduction.cubature_bodies import TWO, body, shapes_of

STEP, STEPS = 0.01, 40
PULL = (0.0, 0.0, -3.0)


def model_of(solid, size=8, **options):
    modes = analysis.linear_modes(solid, 5)
    basis = reduction.modal_derivative_basis(solid, modes, size=size)
    return reduction.reduce(solid, basis, "cubature", **options)


@pytest.fixture(scope="module")
def solid():
    return body(TWO)


@pytest.fixture(scope="module")
def model(solid):
    return model_of(solid)


def test_a_run_of_the_model_follows_the_direct_force(solid, model):
    direct = reduction.reduce(
        solid, reduction.basis_from_array(solid, shapes_from(model)), "direct"
    )
    paths = []
    for one in (model, direct):
        run = runtime.ImplicitNewmark(one, step=STEP, newton=3)
        load = one.gravity(PULL)
        path = []
        for _ in range(STEPS):
            run.advance(load)
            path.append(run.q.copy())
        paths.append(np.array(path))
    own, exact = paths
    largest = np.linalg.norm(exact, axis=1).max()
    assert np.abs(model.displacement(exact[-1])).max() > 0.05  # a large motion
    assert np.linalg.norm(own - exact, axis=1).max() <= 0.03 * largest


def shapes_from(model):
    return np.ascontiguousarray(model.outputs.shapes.transpose(2, 0, 1))


def test_a_model_goes_through_its_file(model, tmp_path):
    path = tmp_path / "model.npz"
    model.save(path)
    again = runtime.load(path)
    q = 0.01 * np.arange(1.0, model.size + 1)
    np.testing.assert_array_equal(again.force(q), model.force(q))
    np.testing.assert_array_equal(again.stiffness(q), model.stiffness(q))
    np.testing.assert_array_equal(again.energy(q), model.energy(q))
    told = again.certificate["force"]
    assert told["kind"] == "cubature"
    assert told["held_out_error"] <= 2 * told["tolerance"]
    assert (
        path.read_bytes() == (again.save(tmp_path / "b.npz"), (tmp_path / "b.npz").read_bytes())[1]
    )


def test_an_undamped_run_keeps_its_energy(model):
    """With converged Newton the average acceleration method drifts by its own error alone."""
    run = runtime.ImplicitNewmark(model, step=0.002, newton=4)
    load = model.gravity(PULL)
    for _ in range(30):
        run.advance(load)
    levels = []
    for _ in range(1500):
        run.advance()
        levels.append(0.5 * run.v @ model.mass @ run.v + model.energy(run.q))
    levels = np.array(levels)
    assert np.ptp(levels) <= 0.02 * levels.mean()


def test_a_training_of_ones_own_is_used_and_checked(solid):
    shapes = shapes_of(solid, 5)
    basis = reduction.basis_from_array(solid, shapes)
    training = reduction.train_cubature(solid, shapes, tolerance=0.2, seed=9)
    model = reduction.reduce(solid, basis, "cubature", training=training)
    assert model.certificate["force"]["seed"] == 9
    with pytest.raises(DefoError, match="leave it out"):
        reduction.reduce(solid, basis, "linear", training=training)
    other = reduction.basis_from_array(solid, shapes[:4])
    with pytest.raises(DefoError, match="5 coordinates"):
        reduction.reduce(solid, other, "cubature", training=training)
