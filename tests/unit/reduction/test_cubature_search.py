"""The parts of a cubature's training: what a point is worth, when it will be done, when to stop."""

import os
import signal

import numpy as np
import pytest

from fenics_defo.fem.compat import MPI
from fenics_defo.reduction.cubature.interruption import Interruption
from fenics_defo.reduction.cubature.nonnegative import GrowingLeastSquares
from fenics_defo.reduction.cubature.progress import seconds_left

COLUMNS, ROWS = 8, 30


def fitted(seed=0):
    """Columns whose weights in the target are all positive, and a fit by all but the last two."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((COLUMNS, ROWS))
    target = rng.uniform(1.0, 2.0, COLUMNS) @ columns + 0.1 * rng.standard_normal(ROWS)
    fit = GrowingLeastSquares(target)
    fit.add(list(range(COLUMNS - 2)), columns[:-2])
    assert len(fit.keys) == COLUMNS - 2
    return columns, target, fit


def square(columns, target):
    """Norm squared of the residual of unbounded least squares."""
    weights = np.linalg.lstsq(columns.T, target, rcond=None)[0]
    return np.sum((target - weights @ columns) ** 2)


def test_a_gain_is_what_the_column_takes_off_the_residual():
    columns, target, fit = fitted()
    gains = fit.gains(columns[-2:])
    before = np.sum(fit.residual**2)
    for place in (COLUMNS - 2, COLUMNS - 1):
        after = square(columns[[*range(COLUMNS - 2), place]], target)
        assert gains[place - COLUMNS + 2] == pytest.approx(before - after, rel=1e-9)
    best = COLUMNS - 2 + int(np.argmax(gains))
    fit.add([best], columns[[best]])
    assert np.sum(fit.residual**2) == pytest.approx(before - gains.max(), rel=1e-9)


def test_nothing_is_gained_from_columns_that_pull_back_or_are_there_already():
    columns, _, fit = fitted()
    assert fit.gains(-columns[-2:]) == pytest.approx(0.0)
    assert fit.gains(columns[:2]) == pytest.approx(0.0, abs=1e-9)


def test_the_cheapest_column_is_the_one_whose_loss_costs_least():
    columns, target, fit = fitted()
    everything = set(fit.keys)
    costs = {key: square(columns[sorted(everything - {key})], target) for key in fit.keys}
    before = fit.weights.copy()
    fewer = fit.without_cheapest()
    assert everything - set(fewer.keys) == {min(costs, key=costs.get)}
    assert np.sum(fewer.residual**2) == pytest.approx(min(costs.values()), rel=1e-9)
    # The one it was copied from stands, also after the copy has grown.
    fewer.add([COLUMNS - 1], columns[[-1]])
    np.testing.assert_array_equal(fit.weights, before)
    assert fit.error == pytest.approx(np.sqrt(square(columns[:-2], target) / (target @ target)))


def test_the_time_left_is_that_of_the_points_to_come():
    steps = np.arange(40)
    errors, seconds = 0.5 * np.exp(-0.05 * steps), 2.0 * steps
    to_come = np.log(errors[-1] / 0.01) / 0.05
    left = seconds_left(errors.tolist(), seconds.tolist(), 0.01, 1000)
    assert 2.0 * to_come <= left <= 2.0 * (to_come + 1)
    assert seconds_left(errors.tolist(), seconds.tolist(), 0.01, 45) == pytest.approx(10.0)
    assert seconds_left([0.5], [0.0], 0.01, 1000) is None
    assert seconds_left([0.5] * 9, list(range(9)), 0.01, 1000) is None


def test_the_first_press_asks_and_the_second_raises():
    before = signal.getsignal(signal.SIGINT)
    with Interruption(MPI.COMM_SELF) as interruption:
        assert not interruption.asked()
        os.kill(os.getpid(), signal.SIGINT)
        assert interruption.asked()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
