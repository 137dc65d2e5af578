"""The derivative of the tangent along a displacement, of all kinds of laws in one body."""

import numpy as np
import pytest
from fem_bodies import MODULI, NEO, mesh_of, source, tapered, usual_groups

from fenics_defo import fem
from fenics_defo.energy import Corotational, HyperelasticEnergy, Invertible, MassSpring

SPRINGS = MassSpring(young=1e5, density=1.2e3)


def body(warped, crushable, **options):
    mesh = mesh_of(source("tetrahedron", mapping=tapered, groups=usual_groups("tetrahedron")))
    laws = {"left": NEO, None: Corotational(**MODULI, tangent=warped), "middle": SPRINGS}
    if options.get("order") == 2:
        laws["middle"] = Invertible(NEO, tangent=crushable)
    return fem.Solid(mesh, laws, **options)


def derivative(solid, u, d):
    """d/ds K(u + s d), dense, in the user's order."""
    assembly = solid.assembly
    matrix = assembly.empty_matrix()
    assembly.fill_tangent_derivative(matrix, solid.nodes.scatter(u), solid.nodes.scatter(d))
    plain = matrix.convert("dense")
    table = plain.getDenseArray().copy()
    plain.destroy()
    matrix.destroy()
    dofs = (3 * solid.nodes.global_rows[:, None] + np.arange(3)).ravel()
    ordered = np.zeros_like(table)
    ordered[np.ix_(dofs, dofs)] = table
    return ordered


@pytest.mark.parametrize("order", [1, 2])
def test_it_is_what_tangents_tend_to(order):
    """With an error that falls with the square of the step, from laws with other tangents too."""
    exact = body("exact", "exact", order=order)
    rng = np.random.default_rng(order)
    u = 0.05 * np.sin(exact.points @ rng.standard_normal((3, 3)))
    d = np.cos(exact.points @ rng.standard_normal((3, 3)))
    found = derivative(body("approximate", "definite", order=order), u, d)
    rough, fine = (
        (exact.tangent(u + s * d) - exact.tangent(u - s * d)).toarray() / (2.0 * s) - found
        for s in (0.02, 0.01)
    )
    assert np.linalg.norm(rough) / np.linalg.norm(fine) == pytest.approx(4.0, rel=0.05)
    assert np.abs(4.0 * fine - rough).max() < 1e-3 * np.abs(found).max()
    assert found == pytest.approx(found.T, abs=1e-12 * np.abs(found).max())


def test_held_rows_are_zero():
    free, held = body("exact", "exact"), body("exact", "exact", fixed=["root", fem.Fixed("9", "y")])
    rng = np.random.default_rng(0)
    u, d = 0.01 * rng.standard_normal((2, *free.points.shape))
    expected, fixed = derivative(free, u, d), held.held.ravel()
    expected[fixed] = 0.0
    expected[:, fixed] = 0.0
    found = derivative(held, u, d)
    assert (found[fixed] == 0.0).all()
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_linear_laws_have_none():
    """A quadratic energy of the user's, and no direction at all."""
    quadratic = HyperelasticEnergy(
        lambda F, c: 0.5 * c["k"] * sum(F[i, j] ** 2 for i in range(3) for j in range(3)),
        {"k": 2.0},
        density=1.0,
    )
    mesh = mesh_of(source("tetrahedron"))
    solid = fem.Solid(mesh, quadratic)
    some = np.ones(solid.points.shape)
    assert (derivative(solid, 0.1 * some, some) == 0.0).all()
    solid = fem.Solid(mesh, Corotational(**MODULI))
    assert (derivative(solid, 0.1 * some, 0.0 * some) == 0.0).all()
