"""Laws that hold for every force law, at any coordinates."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fenics_defo.runtime.forces import CubicForce, ForceLaw, LinearForce
from fenics_defo.runtime.forces.symmetric import unique_count

Array = NDArray[np.float64]

# Gauss's rule with two points on [0, 1] is exact for cubic polynomials.
PLACES = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


@st.composite
def laws(draw: st.DrawFn) -> ForceLaw:
    r = draw(st.integers(1, 7))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    root = rng.normal(size=(r, r))
    if draw(st.booleans()):
        return LinearForce(root + root.T)
    softness = draw(st.sampled_from([0.0, 1e-6, 1.0, 1e6]))
    third, fourth = (softness * rng.normal(size=unique_count(r, order)) for order in (3, 4))
    return CubicForce.from_unique(root @ root.T, third, fourth)


@st.composite
def laws_and_coordinates(draw: st.DrawFn) -> tuple[ForceLaw, Array]:
    """A law and some coordinates (b, r) of its size, of one scale."""
    law = draw(laws())
    bodies = draw(st.integers(2, 5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    scale = 10.0 ** draw(st.integers(-8, 4))
    return law, scale * rng.normal(size=(bodies, law.size))


def size_of_terms(law: ForceLaw, q: Array) -> float:
    """Largest sum of the sizes of what is added up in K at ``q``: round-off is relative to it."""
    if isinstance(law, LinearForce):
        return float(np.abs(law.linear).sum())
    assert isinstance(law, CubicForce)
    reach = np.abs(q).max()
    terms = (law.linear, law.quadratic * reach, law.cubic * reach**2)
    return float(sum(np.abs(term).sum() for term in terms))


@settings(max_examples=60, deadline=None)
@given(laws_and_coordinates())
def test_the_force_is_the_gradient_of_the_energy(case: tuple[ForceLaw, Array]) -> None:
    """On any straight way the force does as much work as the energy grows."""
    law, q = case
    begin, end = q[:2]
    along = begin + PLACES[:, None] * (end - begin)
    work = 0.5 * (law.force(along) @ (end - begin)).sum()
    growth = law.energy(end) - law.energy(begin)
    np.testing.assert_allclose(
        growth, work, rtol=0, atol=1e-13 * size_of_terms(law, q) * np.abs(q).max() ** 2
    )


@settings(max_examples=60, deadline=None)
@given(laws_and_coordinates())
def test_the_stiffness_is_the_gradient_of_the_force(case: tuple[ForceLaw, Array]) -> None:
    law, q = case
    begin, end = q[:2]
    along = begin + PLACES[:, None] * (end - begin)
    gathered = 0.5 * (law.stiffness(along) @ (end - begin)).sum(axis=0)
    growth = law.force(end) - law.force(begin)
    np.testing.assert_allclose(
        growth, gathered, rtol=0, atol=1e-13 * size_of_terms(law, q) * np.abs(q).max()
    )


@settings(max_examples=60, deadline=None)
@given(laws_and_coordinates())
def test_bodies_do_not_know_of_each_other(case: tuple[ForceLaw, Array]) -> None:
    """A batch, its bodies one by one and both evaluators agree; K is exactly symmetric."""
    law, q = case
    terms = size_of_terms(law, q)
    f, k = law.force(q), law.stiffness(q)
    np.testing.assert_array_equal(k, np.swapaxes(k, -1, -2))
    for shape in (q.shape, q.shape[1:]):
        evaluator = law.evaluator(shape)
        for row in range(len(q)):
            chosen = q if len(shape) == 2 else q[row]
            force, stiffness = evaluator.force_and_stiffness(chosen)
            pair = (f, k) if len(shape) == 2 else (f[row], k[row])
            np.testing.assert_allclose(force, pair[0], rtol=0, atol=1e-14 * terms * np.abs(q).max())
            np.testing.assert_allclose(stiffness, pair[1], rtol=0, atol=1e-14 * terms)
            np.testing.assert_array_equal(stiffness, np.swapaxes(stiffness, -1, -2))
            np.testing.assert_array_equal(evaluator.force(chosen), force)


@settings(max_examples=30, deadline=None)
@given(laws())
def test_rest_is_at_rest(law: ForceLaw) -> None:
    rest = np.zeros(law.size)
    np.testing.assert_array_equal(law.force(rest), rest)
    assert law.energy(rest) == 0.0
    linear = law.stiffness(rest)
    tiny = 1e-9 * np.random.default_rng(1).normal(size=law.size)
    softer = law.force(tiny) - linear @ tiny
    bend = size_of_terms(law, np.ones(1)) - size_of_terms(law, np.zeros(1))
    assert np.abs(softer).max() <= bend * np.abs(tiny).max() ** 2 + 1e-13 * np.abs(tiny).max() * (
        np.abs(linear).sum()
    )
