"""Lengths along a direction of descent."""

import math

import numpy as np
import pytest

from fenics_defo.analysis.line_search import flatter


def test_newtons_own_length_is_taken_where_it_is_good():
    tried = []

    def slope_at(length):
        tried.append(length)
        return length - 1.0

    assert flatter(-1.0, slope_at) == 1.0
    assert tried == [1.0]


@pytest.mark.parametrize("minimum", [0.02, 0.3, 1.0, 2.7, 3.9])
def test_the_slope_falls_on_either_side_of_a_minimum(minimum):
    """A quartic about its minimum, from far below Newton's length to far above it."""
    length = flatter(-(minimum**3), lambda x: (x - minimum) ** 3)
    assert abs((length - minimum) ** 3) <= 0.7 * minimum**3


@pytest.mark.parametrize("nothing", [math.inf, math.nan])
def test_infinity_is_kept_away_from(nothing):
    length = flatter(-1.0, lambda x: nothing if x > 0.1 else -1.0 + 5.0 * x)
    assert 0.0 < length <= 0.1


def test_no_end_is_gone_to_as_far_as_allowed():
    assert flatter(-1.0, lambda _: -2.0) == 4.0


def test_only_uphill_is_no_length():
    assert flatter(-1.0, lambda _: 5.0) is None


def test_a_kink_is_passed():
    """The slope jumps from -1 to -3 at a ridge and rises again behind it."""
    length = flatter(-1.0, lambda x: np.where(x < 0.5, -1.0, -3.0 + x).item())
    assert abs(-3.0 + length) <= 0.7
