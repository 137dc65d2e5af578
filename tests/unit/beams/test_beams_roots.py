"""Wave numbers of uniform beams and bars."""

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_defo.beams import BeamError, bar_roots, bending_roots

# Multiplied by 1/cosh x, so that it stays finite.
EQUATIONS = {
    "clamped-free": lambda x: np.cos(x) + 1.0 / np.cosh(x),
    "clamped-clamped": lambda x: np.cos(x) - 1.0 / np.cosh(x),
    "free-free": lambda x: np.cos(x) - 1.0 / np.cosh(x),
    "clamped-pinned": lambda x: np.sin(x) - np.cos(x) * np.tanh(x),
    "free-pinned": lambda x: np.sin(x) - np.cos(x) * np.tanh(x),
    "clamped-sliding": lambda x: np.sin(x) + np.cos(x) * np.tanh(x),
    "free-sliding": lambda x: np.sin(x) + np.cos(x) * np.tanh(x),
    "pinned-pinned": np.sin,
    "sliding-sliding": np.sin,
    "pinned-sliding": np.cos,
}


@pytest.mark.parametrize("supports", EQUATIONS)
def test_roots_are_all_roots_of_the_frequency_equation(supports):
    equation = EQUATIONS[supports]
    grid = np.linspace(0.5, 100.0, 20001)
    values = equation(grid)
    crossings = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    expected = [brentq(equation, grid[i], grid[i + 1], xtol=1e-13) for i in crossings]
    np.testing.assert_allclose(
        bending_roots(len(expected), supports=supports), expected, rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("supports", EQUATIONS)
def test_order_of_the_ends_does_not_matter(supports):
    turned = "-".join(reversed(supports.split("-")))
    np.testing.assert_array_equal(
        bending_roots(7, supports=turned), bending_roots(7, supports=supports)
    )


def test_published_cantilever_roots():
    # Blevins, Formulas for Natural Frequency and Mode Shape.
    expected = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839]
    np.testing.assert_allclose(bending_roots(5), expected, rtol=0.0, atol=5e-9)


@pytest.mark.parametrize("supports", EQUATIONS)
def test_high_roots_neither_overflow_nor_lose_their_spacing(supports):
    roots = bending_roots(100_000, supports=supports)
    assert np.all(np.isfinite(roots))
    np.testing.assert_allclose(np.diff(roots[20:]), np.pi, rtol=1e-9)


def test_bar_roots():
    n = np.arange(1, 6)
    np.testing.assert_allclose(np.cos(bar_roots(5)), 0.0, atol=1e-14)
    np.testing.assert_array_equal(bar_roots(5, ends="free-fixed"), bar_roots(5))
    for ends in ("fixed-fixed", "free-free"):
        np.testing.assert_allclose(bar_roots(5, ends=ends), np.pi * n, rtol=1e-15)


@pytest.mark.parametrize("bad", ["clamped", "clamped-welded", "", "clamped-free-free", None, 3])
def test_unknown_supports_are_named(bad):
    with pytest.raises(BeamError, match="clamped, pinned, sliding, free"):
        bending_roots(1, supports=bad)
    with pytest.raises(BeamError, match="fixed, free"):
        bar_roots(1, ends=bad)


@pytest.mark.parametrize("bad", [0, -1, 1.0, float("nan"), "3", None, True])
def test_bad_counts_are_refused(bad):
    with pytest.raises(BeamError, match="count must be an integer of at least 1"):
        bending_roots(bad)
