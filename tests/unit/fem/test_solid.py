"""A body's energy, forces and matrices: derivatives, limits, exact sums."""

from collections.abc import Callable
from typing import Any

import ffcx.codegeneration.jit
import numpy as np
import pytest
import ufl
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.energy import (
    HyperelasticEnergy,
    LinearElastic,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.errors import DefoError, MeshError, SelectionError
from fenics_defo.fem.compat import MPI, dolfinx
from fenics_defo.fem.imported import MeshData
from tests.unit.fem.fem_bodies import (
    CELLS,
    MODULI,
    NEO,
    SIDES,
    SVK,
    VOLUME,
    bar,
    bend,
    bent,
    mesh_of,
    source,
    tapered,
    usual_groups,
)

Array = NDArray[np.float64]

RUBBER = MooneyRivlin(c10=1.5e4, c01=4e3, bulk=2e5, density=900.0)


def rotation(angle: float = 2.0) -> Array:
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def order_of(error: Callable[[float], float], step: float) -> float:
    """Observed order of a difference quotient."""
    return float(np.log2(error(step) / error(step / 2.0)))


def fibres(F: ufl.core.expr.Expr, c: dict[str, Any]) -> ufl.core.expr.Expr:
    """Fibres along (1, 2, 0)/√5 in a matrix: anisotropic, no stress at rest."""
    E = (F.T * F - ufl.Identity(3)) / 2
    a = ufl.as_vector([1.0 / 5.0**0.5, 2.0 / 5.0**0.5, 0.0])
    return c["mu"] * ufl.inner(E, E) + c["fibre"] * ufl.inner(a, E * a) ** 2


FIBRES = HyperelasticEnergy(fibres, {"mu": 3e4, "fibre": 8e4}, density=1e3)
# Stretched at rest: a pretension along x.
TENSE = HyperelasticEnergy(
    lambda F, c: c["mu"] * ufl.inner(F, F) + c["pull"] * ufl.tr(F),
    {"mu": 1e4, "pull": -3e3},
    density=1.0,
)


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CELLS)
def test_force_and_tangent_are_derivatives(kind: str, order: int, mesh_order: int) -> None:
    solid = bar(kind, order, mesh_order)
    u = bend(solid)
    direction = np.random.default_rng(1).standard_normal(u.shape)
    force, tangent = solid.internal_force(u), solid.tangent(u)
    slope = float((force * direction).sum())
    change = (tangent @ direction.ravel()).reshape(-1, 3)

    def energy_error(h: float) -> float:
        difference = solid.energy(u + h * direction) - solid.energy(u - h * direction)
        return abs(difference / (2.0 * h) / slope - 1.0)

    def force_error(h: float) -> float:
        ends = [solid.internal_force(u + s * h * direction) for s in (1.0, -1.0)]
        return float(np.linalg.norm((ends[0] - ends[1]) / (2.0 * h) - change))

    h = 2e-3 / order**2
    assert order_of(energy_error, h) == pytest.approx(2.0, abs=0.1)
    assert order_of(force_error, h) == pytest.approx(2.0, abs=0.1)
    assert force_error(1e-3 * h) < 1e-6 * np.linalg.norm(change)
    assert abs(tangent - tangent.T).max() < 1e-12 * abs(tangent).max()


# Neither a field nor the displacement is in its second derivative.
NUMBERS = HyperelasticEnergy(
    lambda F, c: 1e4 * ufl.inner(F - ufl.Identity(3), F - ufl.Identity(3)), density=1.0
)


@pytest.mark.parametrize("law", [LinearElastic(**MODULI), SVK, NEO, RUBBER, FIBRES, TENSE, NUMBERS])
def test_the_rest_tangent_is_the_tangent_at_zero(law: Any) -> None:
    solid = bar("tetrahedron", 1, law=law)
    zero = np.zeros_like(solid.points)
    rest, there = solid.tangent(), solid.tangent(zero)
    assert abs(rest - there).max() < 1e-12 * abs(there).max()


@pytest.mark.parametrize(
    ("kind", "order", "mesh_order"),
    [("hexahedron", 1, 1), ("tetrahedron", 2, 1), ("hexahedron", 1, 2)],
)
def test_the_rest_tangent_needs_no_higher_degree(kind: str, order: int, mesh_order: int) -> None:
    """Its own quadrature rule, exact or the same as that of the deformed body."""
    solid = bar(kind, order, mesh_order, mapping=tapered if mesh_order == 1 else bent)
    there = solid.tangent(np.zeros_like(solid.points))
    assert abs(solid.tangent() - there).max() < 1e-12 * abs(there).max()


@pytest.mark.parametrize("law", [SVK, NEO, RUBBER, FIBRES])
def test_rigid_motions_store_no_energy(law: Any) -> None:
    solid = bar("tetrahedron", 1, law=law)
    moved = solid.points @ rotation().T + [1.0, -2.0, 0.5]
    u = moved - solid.points
    scale = 1e5 * VOLUME
    assert abs(solid.energy(u)) < 1e-12 * scale
    assert abs(solid.internal_force(u)).max() < 1e-10 * scale
    assert abs(solid.energy()) < 1e-12 * scale


@pytest.mark.parametrize(("kind", "order", "mesh_order"), CELLS)
def test_patch(kind: str, order: int, mesh_order: int) -> None:
    """F constant: the energy is ψ(F) V, and force acts on boundary nodes only, P N dA."""
    solid = bar(kind, order, mesh_order)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.95, 0.1], [0.05, 0.0, 1.2]])
    u = solid.points @ (F - np.eye(3)).T
    volume = solid.total_mass() / NEO.density
    mu, lmbda = NEO.parameters["mu"], NEO.parameters["lmbda"]
    log = np.log(np.linalg.det(F))
    psi = mu / 2.0 * ((F * F).sum() - 3.0) - mu * log + lmbda / 2.0 * log**2
    assert solid.energy(u) == pytest.approx(psi * volume, rel=1e-12)
    stress = mu * F + (lmbda * log - mu) * np.linalg.inv(F).T
    force = solid.internal_force(u)
    np.testing.assert_allclose(
        np.einsum("ni,nj->ij", force, solid.points), stress * volume, rtol=1e-10, atol=1e-6
    )
    inner = ~on_surface(solid)
    assert inner.any()
    assert abs(force[inner]).max(initial=0.0) < 1e-12 * abs(force).max()


def on_surface(solid: fem.Solid) -> NDArray[np.bool_]:
    mesh = solid.space.mesh
    mesh.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    mask = np.zeros(solid.nodes.size, bool)
    dofs = dolfinx.fem.locate_dofs_topological(solid.space, 2, facets)
    mask[solid.nodes.rows[dofs]] = True
    return mask


def test_two_laws_in_one_body_add_up() -> None:
    """Each region alone has the energy that the body's part has."""
    mesh_data = mesh_of(source("tetrahedron", groups=usual_groups("tetrahedron"), mapping=tapered))
    both = fem.Solid(mesh_data, {"left": NEO, "right": SVK})
    u = bend(both, 0.3)
    none = {"young": 1e-8, "poisson": 0.0, "density": 1e-8}
    left = fem.Solid(mesh_data, {"left": NEO, "right": NeoHookean(**none)})
    right = fem.Solid(mesh_data, {"right": SVK, "left": StVenantKirchhoff(**none)})
    assert both.energy(u) == pytest.approx(left.energy(u) + right.energy(u), rel=1e-10)
    np.testing.assert_allclose(
        both.internal_force(u), left.internal_force(u) + right.internal_force(u), atol=1e-6
    )
    difference = both.tangent(u) - left.tangent(u) - right.tangent(u)
    assert abs(difference).max() < 1e-10 * abs(both.tangent(u)).max()


def test_a_field_of_one_value_is_that_value() -> None:
    solid = bar("tetrahedron", 1)
    count = len(solid.cells)
    fields = {name: np.full(count, value) for name, value in MODULI.items()}
    other = fem.Solid(solid.mesh_data, NeoHookean(**fields))
    u = bend(solid)
    assert other.energy(u) == pytest.approx(solid.energy(u), rel=1e-14)
    stiff = np.where(np.arange(count) == 7, 2.0, 1.0)
    fields["young"] = fields["young"] * stiff
    extra = fem.Solid(solid.mesh_data, NeoHookean(**fields)).energy(u) - solid.energy(u)
    alone = fem.build_mesh(solid.points[solid.cells[7]], np.arange(4)[None])
    assert extra == pytest.approx(fem.Solid(alone, NEO).energy(u[solid.cells[7]]), rel=1e-9)


def test_constraints_hold_components() -> None:
    mesh_data = mesh_of(source("tetrahedron", groups=usual_groups("tetrahedron")))
    fixed = [fem.Fixed("root", "xy"), fem.Fixed("pins", "x"), "x > 1.99", fem.Fixed("y<1e-9", "z")]
    solid = fem.Solid(mesh_data, NEO, fixed=fixed)
    x, y, _ = solid.points.T
    root, end, side = x < 1e-9, x > 1.99, y < 1e-9
    np.testing.assert_array_equal(solid.held, np.column_stack([root | end, root | end, end | side]))
    K, M = solid.assembly.stiffness_matrix(diagonal=3.0), solid.assembly.mass.matrix()
    held = solid.nodes.scatter(solid.held).ravel()
    dense, plain = (dense_of(A) for A in (K, M))
    K.destroy()
    M.destroy()
    np.testing.assert_array_equal(dense[held][:, held], 3.0 * np.eye(held.sum()))
    assert not plain[held].any()
    assert not plain[:, held].any()
    assert not dense[held][:, ~held].any()
    rows = 3 * np.repeat(solid.nodes.rows, 3) + np.tile(np.arange(3), len(solid.nodes.rows))
    for inside, whole in ((dense, solid.tangent()), (plain, solid.mass())):
        free = rows[~held]
        np.testing.assert_array_equal(inside[~held][:, ~held], whole.toarray()[np.ix_(free, free)])


def dense_of(matrix: Any) -> Array:
    plain = matrix.convert("aij")
    return plain.getValues(range(plain.size[0]), range(plain.size[1]))


def test_no_constraint_and_one_alone() -> None:
    mesh_data = mesh_of(source("hexahedron", groups=usual_groups("hexahedron")))
    assert not fem.Solid(mesh_data, NEO).held.any()
    for one in ("root", 7, fem.Fixed("root")):
        held = fem.Solid(mesh_data, NEO, fixed=one).held
        np.testing.assert_array_equal(held.all(axis=1), held.any(axis=1))
        assert held.sum() == 18


def counted(monkeypatch: pytest.MonkeyPatch, module: Any, name: str) -> list[int]:
    """A list that grows with each call of a module's function."""
    calls: list[int] = []
    real = getattr(module, name)
    monkeypatch.setattr(module, name, lambda *a, **k: (calls.append(1), real(*a, **k))[1])
    return calls


def test_nothing_is_compiled_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = counted(monkeypatch, dolfinx.jit, "ffcx_jit")
    compilations = counted(monkeypatch, ffcx.codegeneration.jit, "_compile_objects")
    mesh = source("tetrahedron", mapping=tapered, groups=usual_groups("tetrahedron"))

    def use(solid: fem.Solid) -> None:
        for size in (0.1, 0.2):
            u = bend(solid, size)
            solid.energy(u), solid.internal_force(u), solid.tangent(u), solid.tangent()
            solid.mass(), solid.lumped_mass(), solid.total_mass()

    first = fem.Solid(mesh_of(mesh), NEO)
    use(first)
    assert len(calls) == 6  # energy, force, two tangents, mass, the pattern
    use(first)
    assert len(calls) == 6
    compilations.clear()
    stiffer = NeoHookean(young=3.3e5, poisson=0.11, density=77.0)
    use(fem.Solid(mesh_of(mesh), stiffer, fixed=["root"]))
    use(fem.Solid(mesh_of(mesh), {None: NEO, "left": stiffer}))
    assert len(calls) == 18
    assert not compilations


def test_dolfinx_own_mesh_data() -> None:
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_SELF, [[0, 0, 0], SIDES], [2, 2, 1], dolfinx.mesh.CellType.hexahedron
    )
    solid = fem.Solid(MeshData(mesh, None, None, None, None, {}), NEO, fixed=["x==0"])
    assert solid.total_mass() == pytest.approx(NEO.density * VOLUME)
    assert solid.held.sum() == 18
    assert solid.dof_count == 54 == 3 * len(solid.record.node_numbers)


@pytest.mark.parametrize(
    ("bad", "problem"),
    [
        (np.zeros(12), r"shape \(27, 3\), got \(12,\)"),
        (np.zeros((23, 3)), r"shape \(27, 3\), got \(23, 3\)"),
        (np.full((27, 3), np.nan), "finite"),
        (np.full((27, 3), np.inf), "finite"),
    ],
)
def test_displacements_are_checked(bad: Array, problem: str) -> None:
    solid = bar("hexahedron", 1)
    for method in (solid.energy, solid.internal_force, solid.tangent):
        with pytest.raises(DefoError, match=problem):
            method(bad)


@pytest.mark.parametrize("order", [0, 3, "2", None])
def test_the_order_is_checked(order: Any) -> None:
    with pytest.raises(DefoError, match="order must be 1 or 2"):
        fem.Solid(bar("hexahedron", 1).mesh_data, NEO, order=order)


@pytest.mark.parametrize("components", ["", "w", "xw", 3, None, ["xy"], {"x": 1}])
def test_components_are_checked(components: Any) -> None:
    with pytest.raises(SelectionError, match="components"):
        fem.Fixed("root", components)


def test_flat_meshes_are_refused() -> None:
    mesh = dolfinx.mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    with pytest.raises(MeshError, match="triangle"):
        fem.Solid(MeshData(mesh, None, None, None, None, {}), NEO)
