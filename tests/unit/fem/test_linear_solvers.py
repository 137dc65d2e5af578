"""Solvers of symmetric systems: agreement, accuracy, reuse, what they say of bad matrices."""

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any, get_args

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse

from fenics_defo import fem
from fenics_defo.energy import NeoHookean
from fenics_defo.errors import DefoError, SolverError
from fenics_defo.fem import gradients
from fenics_defo.fem.compat import PETSc
from fenics_defo.fem.linalg import combine
from fenics_defo.fem.linear_solvers import Cholesky, Kind, linear_solver
from tests.unit.fem.fem_bodies import MODULI, NEO, bend, mesh_of, source, tapered

Array = NDArray[np.float64]
KINDS = get_args(Kind)


def clamped(cells: tuple[int, int, int] = (6, 3, 3), law: Any = NEO) -> fem.Solid:
    mesh = source("tetrahedron", cells=cells, mapping=tapered)
    return fem.Solid(mesh_of(mesh), law, fixed=["x<1e-9"])


@contextmanager
def stiffness(solid: fem.Solid, size: float = 0.05, diagonal: float = 1.0) -> Iterator[Any]:
    matrix = solid.assembly.empty_matrix()
    solid.assembly.fill_tangent(matrix, solid.nodes.scatter(bend(solid, size)), diagonal=diagonal)
    yield matrix
    matrix.destroy()


def load(solid: fem.Solid, seed: int = 0) -> Array:
    values = np.random.default_rng(seed).standard_normal(3 * solid.assembly.owned)
    return np.where(solid.assembly.held[: solid.assembly.owned].ravel(), 0.0, values)


def scipy_matrix(matrix: Any) -> sparse.csr_array:
    plain = matrix.convert("aij", PETSc.Mat())
    offsets, columns, values = (np.array(part) for part in plain.getValuesCSR())
    size = plain.size
    plain.destroy()
    return sparse.csr_array((values, columns, offsets), shape=size)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("diagonal", [1.0, 1e6])
def test_each_gives_scipys_solution(kind: Kind, diagonal: float) -> None:
    solid = clamped()
    b = load(solid)
    with (
        stiffness(solid, diagonal=diagonal) as matrix,
        closing(linear_solver(kind, solid.assembly, tolerance=1e-10)) as solver,
    ):
        solver.prepare(matrix)
        x = solver.solve(b)
        expected = sparse.linalg.spsolve(scipy_matrix(matrix).tocsc(), b)
        np.testing.assert_allclose(x, expected, atol=1e-8 * abs(expected).max(), rtol=0.0)
        assert not x[b == 0.0].any()
        assert (solver.iterations == 1) is (kind == "cholesky")


@pytest.mark.parametrize("kind", KINDS)
def test_a_kept_solver_is_as_good_for_the_next_matrix(kind: Kind) -> None:
    """Jacobi's blocks are those of the present matrix, and so are the factors."""
    solid = clamped()
    b = load(solid)
    kept = linear_solver(kind, solid.assembly)
    with closing(kept), stiffness(solid) as matrix, closing(fresh_mass(solid)) as mass:
        for scale, mass_scale in ((1.0, 0.0), (1.0, 1e6), (1e-6, 1.0)):
            solid.assembly.fill_tangent(matrix, solid.nodes.scatter(bend(solid, 0.1)))
            combine(matrix, matrix, scale, mass.matrix, mass_scale)
            with closing(linear_solver(kind, solid.assembly)) as fresh:
                fresh.prepare(matrix)
                expected = fresh.solve(b)
                kept.prepare(matrix)
                found = kept.solve(b)
                np.testing.assert_allclose(found, expected, atol=1e-4 * abs(expected).max())
                if kind == "pcg-jacobi":
                    assert kept.iterations == fresh.iterations


class fresh_mass:
    def __init__(self, solid: fem.Solid) -> None:
        self.matrix = solid.assembly.mass.matrix()

    def close(self) -> None:
        self.matrix.destroy()


def test_combine_is_the_sum_of_both() -> None:
    solid = clamped()
    with stiffness(solid) as K, closing(fresh_mass(solid)) as mass:
        target = solid.assembly.empty_matrix()
        for scale, mass_scale in ((2.0, 3.0), (1.0, 0.0), (0.0, 1.0)):
            combine(target, K, scale, mass.matrix, mass_scale)
            expected = scale * scipy_matrix(K) + mass_scale * scipy_matrix(mass.matrix)
            assert abs(scipy_matrix(target) - expected).max() < 1e-15 * abs(expected).max()
            assert target.getInfo()["mallocs"] == 0
        combine(K, K, 0.0, mass.matrix, 1.0)
        assert abs(scipy_matrix(K) - expected).max() == 0.0
        target.destroy()


def test_uneven_stiffness_costs_iterations() -> None:
    """The direct solver does not feel it."""
    counts = []
    for decades in (0, 2, 4):
        young = 1e5 * 10.0 ** (decades * np.random.default_rng(0).random(6 * 54))
        solid = clamped(law=NeoHookean(**(MODULI | {"young": young})))
        with (
            stiffness(solid, 0.0) as matrix,
            closing(linear_solver("pcg-jacobi", solid.assembly)) as solver,
        ):
            solver.prepare(matrix)
            solver.solve(load(solid))
            counts.append(solver.iterations)
    assert counts[0] < counts[1] < counts[2]


def test_multigrid_needs_few_iterations_on_any_mesh() -> None:
    counts: dict[Kind, list[int]] = {"pcg-jacobi": [], "pcg-amg": []}
    for cells in ((4, 2, 2), (16, 8, 8)):
        solid = clamped(cells)
        with stiffness(solid, 0.0) as matrix:
            for kind, found in counts.items():
                with closing(linear_solver(kind, solid.assembly)) as solver:
                    solver.prepare(matrix)
                    solver.solve(load(solid))
                    found.append(solver.iterations)
    assert counts["pcg-jacobi"][1] > 2 * counts["pcg-jacobi"][0]
    assert counts["pcg-amg"][1] < 40
    assert counts["pcg-amg"][1] < counts["pcg-jacobi"][1] / 3


def test_multigrid_is_kept_until_it_serves_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    solid = clamped((8, 4, 4))
    b = load(solid)
    made = []
    own = gradients.MultigridGradients._preconditioned
    monkeypatch.setattr(
        gradients.MultigridGradients,
        "_preconditioned",
        lambda self, matrix: made.append(1) or own(self, matrix),
    )
    with (
        stiffness(solid, 0.0) as matrix,
        closing(fresh_mass(solid)) as mass,
        closing(linear_solver("pcg-amg", solid.assembly)) as solver,
    ):
        for size in (0.0, 0.01, 0.02):
            solid.assembly.fill_tangent(matrix, solid.nodes.scatter(bend(solid, size)))
            solver.prepare(matrix)
            solver.solve(b)
        assert len(made) == 1
        combine(matrix, matrix, 1e-9, mass.matrix, 1.0)
        solver.prepare(matrix)
        solver.solve(b)
        slow = solver.iterations
        solver.prepare(matrix)
        solver.solve(b)
        assert len(made) == 2
        assert solver.iterations < slow / 2


@pytest.mark.parametrize("kind", ["pcg-jacobi", "pcg-amg"])
def test_iterations_refuse_what_is_not_positive_definite(kind: Kind) -> None:
    solid = clamped()
    with (
        stiffness(solid) as matrix,
        closing(fresh_mass(solid)) as mass,
        closing(linear_solver(kind, solid.assembly, tolerance=1e-12)) as solver,
    ):
        combine(matrix, matrix, 1.0, mass.matrix, -1e4)
        solver.prepare(matrix)
        with pytest.raises(SolverError, match=r"not positive definite.*cholesky"):
            solver.solve(load(solid))


def test_the_direct_solver_factorises_indefinite_matrices(
    caplog: pytest.LogCaptureFixture,
) -> None:
    solid = clamped()
    b = load(solid)
    solver = Cholesky()
    with closing(solver), stiffness(solid) as matrix, closing(fresh_mass(solid)) as mass:
        solver.prepare(matrix)
        assert solver.negative_eigenvalues == 0
        assert not caplog.records
        combine(matrix, matrix, 1.0, mass.matrix, -1e4)
        dense = scipy_matrix(matrix).toarray()
        with caplog.at_level(logging.WARNING):
            solver.prepare(matrix)
        expected = int((np.linalg.eigvalsh(dense) < 0.0).sum())
        assert solver.negative_eigenvalues == expected > 0
        assert f"{expected} negative eigenvalues" in caplog.text
        residual = dense @ solver.solve(b) - b
        assert abs(residual).max() < 1e-8 * abs(b).max()
        solid.assembly.fill_tangent(matrix, solid.nodes.scatter(0.0 * solid.points))
        solver.prepare(matrix)
        assert solver.negative_eigenvalues == 0
        solver.prepare(matrix)
        residual = scipy_matrix(matrix) @ solver.solve(b) - b
        assert abs(residual).max() < 1e-8 * abs(b).max()


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_finite_is_refused(kind: Kind) -> None:
    solid = clamped()
    local = solid.nodes.scatter(bend(solid))
    local[-1] = np.nan
    with closing(linear_solver(kind, solid.assembly)) as solver, stiffness(solid) as matrix:
        solid.assembly.fill_tangent(matrix, local)
        with pytest.raises(SolverError, match=r"finite|NaN"):
            solver.prepare(matrix)
        solid.assembly.fill_tangent(matrix, solid.nodes.scatter(bend(solid)))
        solver.prepare(matrix)  # it has not broken
        assert np.isfinite(solver.solve(load(solid))).all()


def test_a_node_without_stiffness_is_told() -> None:
    solid = clamped()
    matrix = solid.assembly.empty_matrix()
    with (
        closing(linear_solver("pcg-jacobi", solid.assembly)) as solver,
        pytest.raises(SolverError, match="a node has no stiffness"),
    ):
        solver.prepare(matrix)
    matrix.destroy()


def test_iterations_have_a_limit() -> None:
    solid = clamped()
    with (
        stiffness(solid) as matrix,
        closing(linear_solver("pcg-jacobi", solid.assembly, iterations=3)) as solver,
    ):
        solver.prepare(matrix)
        with pytest.raises(SolverError, match="did not converge in 3 iterations; use the direct"):
            solver.solve(load(solid))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "lu"}, "one of .*cholesky.*got 'lu'"),
        ({"kind": "pcg-jacobi", "tolerance": 0.0}, "between 0 and 1, got 0.0"),
        ({"kind": "pcg-jacobi", "tolerance": float("nan")}, "between 0 and 1, got nan"),
    ],
)
def test_wrong_choices_are_told(options: dict[str, Any], message: str) -> None:
    with pytest.raises(DefoError, match=message):
        linear_solver(options.pop("kind"), clamped().assembly, **options)
