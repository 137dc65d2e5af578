import itertools
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.runtime.forces import CubicForce, LinearForce, TaylorForce
from fenics_defo.runtime.forces.symmetric import (
    diagonal_weights,
    pairs,
    unique_count,
    unique_indices,
)

Array = NDArray[np.float64]
SIZES = (1, 2, 3, 6)


def symmetric_tensor(rng: np.random.Generator, r: int, order: int) -> Array:
    """A random tensor, the same under any exchange of its indices."""
    raw = rng.normal(size=(r,) * order)
    turns = [np.transpose(raw, turn) for turn in itertools.permutations(range(order))]
    return np.asarray(sum(turns) / len(turns))


class Polynomial:
    """The textbook form of the energy with dense tensors, by einsum."""

    def __init__(self, r: int, seed: int = 3) -> None:
        rng = np.random.default_rng(seed)
        self.k1 = symmetric_tensor(rng, r, 2) + 3.0 * np.eye(r)
        self.c3 = symmetric_tensor(rng, r, 3)
        self.c4 = symmetric_tensor(rng, r, 4)

    def law(self) -> CubicForce:
        r = len(self.k1)
        i, j = pairs(r)
        cubic = self.c4[i, j][:, i, j] * diagonal_weights(r)
        return CubicForce(self.k1, self.c3[i, j], cubic)

    def energy(self, q: Array) -> Array:
        return np.asarray(
            np.einsum("ij,...i,...j", self.k1, q, q) / 2
            + np.einsum("ijk,...i,...j,...k", self.c3, q, q, q) / 6
            + np.einsum("ijkl,...i,...j,...k,...l", self.c4, q, q, q, q) / 24
        )

    def force(self, q: Array) -> Array:
        return np.asarray(
            np.einsum("ij,...j->...i", self.k1, q)
            + np.einsum("ijk,...j,...k->...i", self.c3, q, q) / 2
            + np.einsum("ijkl,...j,...k,...l->...i", self.c4, q, q, q) / 6
        )

    def stiffness(self, q: Array) -> Array:
        return np.asarray(
            self.k1
            + np.einsum("ijk,...k->...ij", self.c3, q)
            + np.einsum("ijkl,...k,...l->...ij", self.c4, q, q) / 2
        )


@pytest.mark.parametrize("r", SIZES)
@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
def test_it_is_the_polynomial_of_its_tensors(r: int, shape: tuple[int, ...]) -> None:
    polynomial = Polynomial(r)
    law = polynomial.law()
    q = np.random.default_rng(r).normal(size=(*shape, r))
    for name in ("energy", "force", "stiffness"):
        found = getattr(law, name)(q)
        np.testing.assert_allclose(found, getattr(polynomial, name)(q), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("make", [lambda p: p.law(), lambda p: LinearForce(p.k1)])
def test_each_is_the_derivative_of_the_one_before(
    make: Callable[[Polynomial], CubicForce | LinearForce],
) -> None:
    """Central differences miss the derivative by terms of order h^2."""
    law = make(Polynomial(5))
    q, way = np.random.default_rng(1).normal(size=(2, 5))
    errors = []
    for h in (1e-2, 5e-3):
        forward, backward = q + h * way, q - h * way
        slope = (law.energy(forward) - law.energy(backward)) / (2 * h)
        change = (law.force(forward) - law.force(backward)) / (2 * h)
        errors.append(
            [abs(slope - law.force(q) @ way), np.abs(change - law.stiffness(q) @ way).max()]
        )
    coarse, fine = np.maximum(errors, 1e-10)
    np.testing.assert_array_less(fine, np.maximum(coarse / 3.8, 1.1e-10))


@pytest.mark.parametrize("shape", [(6,), (1, 6), (4, 6)])
@pytest.mark.parametrize("law", [Polynomial(6).law(), LinearForce(Polynomial(6).k1)])
def test_an_evaluator_gives_what_the_law_gives(
    law: CubicForce | LinearForce, shape: tuple[int, ...]
) -> None:
    evaluator = law.evaluator(shape)
    for seed in (1, 2):
        q = np.random.default_rng(seed).normal(size=shape)
        kept = q.copy()
        np.testing.assert_allclose(evaluator.force(q), law.force(q), rtol=1e-13)
        f, k = evaluator.force_and_stiffness(q)
        np.testing.assert_allclose(f, law.force(q), rtol=1e-13)
        np.testing.assert_allclose(k, law.stiffness(q), rtol=1e-13)
        np.testing.assert_array_equal(k, np.swapaxes(k, -1, -2))
        np.testing.assert_array_equal(q, kept)


@pytest.mark.parametrize("law", [Polynomial(8).law(), LinearForce(Polynomial(8).k1)])
@pytest.mark.parametrize("shape", [(8,), (64, 8)])
def test_an_evaluator_allocates_next_to_nothing(
    law: CubicForce | LinearForce, shape: tuple[int, ...]
) -> None:
    """For one body, no more than the objects of Python; for 64 they would take 4 KiB for q."""
    evaluator = law.evaluator(shape)
    q = np.ones(shape)
    evaluator.force_and_stiffness(q)
    tracemalloc.start()
    try:
        for _ in range(5):
            evaluator.force_and_stiffness(q)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 2048


def test_a_batch_is_its_bodies_one_by_one() -> None:
    law = Polynomial(6).law()
    q = np.random.default_rng(5).normal(size=(40, 6))
    np.testing.assert_allclose(law.force(q), [law.force(one) for one in q], rtol=1e-12)
    np.testing.assert_allclose(law.stiffness(q), [law.stiffness(one) for one in q], rtol=1e-12)
    np.testing.assert_allclose(law.energy(q), [law.energy(one) for one in q], rtol=1e-12)


def test_more_bodies_than_one_buffer_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    law = Polynomial(3).law()
    q = np.random.default_rng(5).normal(size=(7, 3))
    whole = law.stiffness(q)
    monkeypatch.setattr("fenics_defo.runtime.forces.cubic._BUFFER", 13)  # two bodies of six pairs
    np.testing.assert_allclose(law.stiffness(q), whole, rtol=1e-13)
    assert law.stiffness(q[:0]).shape == (0, 3, 3)


def test_results_of_a_law_are_the_callers_own() -> None:
    law = Polynomial(3).law()
    q = np.ones(3)
    first = law.force(q), law.stiffness(q)
    kept = first[0].copy(), first[1].copy()
    law.force(2 * q), law.stiffness(2 * q)
    np.testing.assert_array_equal(first[0], kept[0])
    np.testing.assert_array_equal(first[1], kept[1])


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_places_of_unique_coefficients(order: int) -> None:
    r = 5
    indices = unique_indices(r, order)
    assert indices.shape == (order, unique_count(r, order))
    assert set(map(tuple, indices.T.tolist())) == set(
        itertools.combinations_with_replacement(range(r), order)
    )
    np.testing.assert_array_equal(unique_indices(3, order), indices[:, : unique_count(3, order)])


@pytest.mark.parametrize("r", SIZES)
def test_unique_coefficients_make_the_same_law(r: int) -> None:
    polynomial = Polynomial(r)
    third = polynomial.c3[tuple(unique_indices(r, 3))]
    fourth = polynomial.c4[tuple(unique_indices(r, 4))]
    law = CubicForce.from_unique(polynomial.k1, third, fourth)
    np.testing.assert_allclose(law.quadratic, polynomial.law().quadratic, rtol=1e-14)
    np.testing.assert_allclose(law.cubic, polynomial.law().cubic, rtol=1e-13)


@pytest.mark.parametrize("kind", [CubicForce, TaylorForce])
def test_arrays_come_back_bit_by_bit(kind: type[CubicForce]) -> None:
    rng = np.random.default_rng(8)
    third = rng.normal(size=unique_count(4, 3)) * 10.0 ** rng.integers(-320, 300, size=20)
    fourth = rng.normal(size=unique_count(4, 4))
    fourth[:3] = -0.0, 5e-324, 3e-308
    law = kind.from_unique(np.eye(4), third, fourth)
    again = kind.from_arrays(law.arrays())
    assert type(again) is kind
    for name in ("linear", "quadratic", "cubic"):
        assert getattr(again, name).tobytes() == getattr(law, name).tobytes()
    assert {n: a.tobytes() for n, a in again.arrays().items()} == {
        n: a.tobytes() for n, a in law.arrays().items()
    }


def test_round_off_is_made_symmetric() -> None:
    exact = Polynomial(4).law()
    noise = 1.0 + 1e-13 * np.random.default_rng(2).normal(size=exact.cubic.shape)
    law = CubicForce(exact.linear, exact.quadratic, exact.cubic * noise)
    full = law.cubic / diagonal_weights(4)
    np.testing.assert_array_equal(full, full.T)
    np.testing.assert_allclose(law.cubic, exact.cubic, rtol=1e-12)


@pytest.mark.parametrize(("row", "column"), [(1, 7), (7, 1), (2, 4), (4, 2), (0, 1), (1, 0)])
def test_one_coefficient_apart_from_its_equals_is_refused(row: int, column: int) -> None:
    """At the pairs 01 and 22, 02 and 11, 00 and 01 of 00, 01, 02, 03, 11, 12, 13, 22, 23, 33."""
    exact = Polynomial(4).law()
    cubic = exact.cubic.copy()
    cubic[row, column] += 1e-6 * np.abs(cubic).max()
    with pytest.raises(ValueError, match="not derivatives of an energy"):
        CubicForce(exact.linear, exact.quadratic, cubic)
    quadratic = exact.quadratic.copy()
    quadratic[row, column % 4] += 1e-6 * np.abs(quadratic).max()
    with pytest.raises(ValueError, match="not derivatives of an energy"):
        CubicForce(exact.linear, quadratic, exact.cubic)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"linear": np.ones(3)}, r"linear must have the shape \(r, r\)"),
        ({"linear": np.zeros((0, 0))}, r"linear must have the shape \(r, r\)"),
        ({"linear": np.triu(np.ones((3, 3)))}, "linear must be symmetric"),
        ({"linear": np.full((3, 3), np.nan)}, "linear holds values that are not finite"),
        ({"linear": np.eye(3) * 1j}, "linear must hold real numbers"),
        ({"quadratic": np.zeros((6, 4))}, r"quadratic must have the shape \(6, 3\)"),
        ({"quadratic": np.full((6, 3), np.inf)}, "quadratic holds values that are not finite"),
        ({"cubic": np.zeros((6, 5))}, r"cubic must have the shape \(6, 6\)"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Array], message: str) -> None:
    law = Polynomial(3).law()
    given = {"linear": law.linear, "quadratic": law.quadratic, "cubic": law.cubic} | changes
    with pytest.raises(ValueError, match=message):
        CubicForce(**given)


@pytest.mark.parametrize("law", [Polynomial(3).law(), LinearForce(np.eye(3))])
@pytest.mark.parametrize("q", [np.zeros(4), np.zeros((3, 2)), np.float64(1.0)])
def test_other_numbers_of_coordinates_are_refused(law: CubicForce | LinearForce, q: Array) -> None:
    for name in ("force", "stiffness", "energy"):
        with pytest.raises(ValueError, match=r"q must have the shape \(\.\.\., 3\)"):
            getattr(law, name)(q)


def test_arrays_of_a_law_are_read_only() -> None:
    law = Polynomial(3).law()
    for array in (law.linear, law.quadratic, law.cubic, LinearForce(np.eye(2)).linear):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
