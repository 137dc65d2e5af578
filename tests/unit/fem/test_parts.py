"""Point laws and springs beside UFL laws: derivatives, patches, sums, the stiffness at rest."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo import analysis, fem
from fenics_defo.energy import (
    Corotational,
    Invertible,
    LinearElastic,
    MassSpring,
    NeoHookean,
    PointResponse,
    StVenantKirchhoff,
)
from fenics_defo.errors import MaterialError
from fenics_defo.fem.compat import PETSc
from tests.unit.fem.fem_bodies import (
    CELLS,
    MODULI,
    NEO,
    SVK,
    bar,
    bend,
    bent,
    mesh_of,
    source,
    tapered,
    usual_groups,
)
from tests.unit.fem.test_solid import on_surface, order_of, rotation

Array = NDArray[np.float64]

COROTATIONAL = Corotational(**MODULI)
INVERTIBLE = Invertible(NEO, tangent="exact")
SPRINGS = MassSpring(young=1e5, density=1.2e3)
ALL_CELLS = [*CELLS, ("tetrahedron", 2, 2), ("hexahedron", 1, 2)]


@dataclass(frozen=True)
class StVenantKirchhoffAtPoints:
    """The law of the same name by another way: NumPy instead of UFL."""

    record: StVenantKirchhoff

    @property
    def density(self) -> Any:
        return self.record.density

    @property
    def parameters(self) -> Mapping[str, Any]:
        return self.record.parameters

    @property
    def formula(self) -> Hashable:
        return "StVK at points"

    def linearised(self) -> Any:
        raise MaterialError("not told, so that its own tangent is taken at rest")

    def respond(
        self, F: Array, parameters: Mapping[str, Any], *, tangent: bool, out: PointResponse
    ) -> PointResponse:
        one = np.eye(3)
        mu = np.broadcast_to(parameters["mu"], len(F))
        lmbda = np.broadcast_to(parameters["lmbda"], len(F))
        E = 0.5 * (np.einsum("mki,mkj->mij", F, F) - one)
        trace = np.einsum("mii->m", E)
        S = 2.0 * mu[:, None, None] * E + (lmbda * trace)[:, None, None] * one
        out.energy[:] = mu * np.einsum("mij,mij->m", E, E) + 0.5 * lmbda * trace**2
        out.stress[:] = F @ S
        if tangent:
            assert out.tangent is not None
            left = np.einsum("mik,mjk->mij", F, F)
            out.tangent[:] = np.einsum("ik,mlj->mijkl", one, S)
            out.tangent[:] += np.einsum("m,mij,mkl->mijkl", lmbda, F, F)
            out.tangent[:] += np.einsum("m,mil,mkj->mijkl", mu, F, F)
            out.tangent[:] += np.einsum("m,mik,jl->mijkl", mu, left, one)
        return out


@pytest.mark.parametrize(("kind", "order", "mesh_order"), ALL_CELLS)
def test_a_law_at_points_equals_the_same_law_in_ufl(kind: str, order: int, mesh_order: int) -> None:
    """The loops over cells and points give what FFCx's kernels give, with cell fields too."""
    mesh = source(kind, order=mesh_order, mapping=tapered if mesh_order == 1 else bent)
    young = 1e5 * (1.0 + 0.1 * np.arange(len(mesh.cells)))
    law, mesh_data = StVenantKirchhoff(**(MODULI | {"young": young})), mesh_of(mesh)
    ufl = fem.Solid(mesh_data, law, order=order)
    points = fem.Solid(mesh_data, StVenantKirchhoffAtPoints(law), order=order)
    u = bend(ufl)
    assert points.energy(u) == pytest.approx(ufl.energy(u), rel=1e-12)
    force, tangent, rest = ufl.internal_force(u), ufl.tangent(u), ufl.tangent(0.0 * u)
    assert abs(points.internal_force(u) - force).max() < 1e-12 * abs(force).max()
    assert abs(points.tangent(u) - tangent).max() < 1e-12 * abs(tangent).max()
    assert abs(points.tangent() - rest).max() < 1e-12 * abs(rest).max()
    assert ufl.is_isotropic_at_rest
    assert not points.is_isotropic_at_rest


def mixed(kind: str) -> fem.Solid:
    """UFL, points and springs in one body, one of them with a field."""
    mesh = source(kind, mapping=tapered, groups=usual_groups(kind))
    young = 1e5 + np.arange(len(mesh.cells))
    corotational = Corotational(**(MODULI | {"young": young}))
    return fem.Solid(mesh_of(mesh), {"left": NEO, None: corotational, "middle": SPRINGS})


BODIES = {
    **{f"corotational {k} {o}": (k, o, COROTATIONAL) for k, o, _ in CELLS},
    "invertible": ("tetrahedron", 1, INVERTIBLE),
    "springs tetrahedron": ("tetrahedron", 1, SPRINGS),
    "springs hexahedron": ("hexahedron", 1, SPRINGS),
    "mixed tetrahedron": ("tetrahedron", 1, None),
    "mixed hexahedron": ("hexahedron", 1, None),
}


def body(name: str) -> fem.Solid:
    kind, order, law = BODIES[name]
    return mixed(kind) if law is None else bar(kind, order, law=law)


@pytest.mark.parametrize("name", BODIES)
def test_force_and_tangent_of_each_part_are_derivatives(name: str) -> None:
    solid = body(name)
    u = bend(solid)
    direction = np.random.default_rng(1).standard_normal(u.shape)
    slope = float((solid.internal_force(u) * direction).sum())
    tangent = solid.tangent(u)
    change = (tangent @ direction.ravel()).reshape(-1, 3)

    def energy_error(h: float) -> float:
        difference = solid.energy(u + h * direction) - solid.energy(u - h * direction)
        return abs(difference / (2.0 * h) / slope - 1.0)

    def force_error(h: float) -> float:
        ends = [solid.internal_force(u + s * h * direction) for s in (1.0, -1.0)]
        return float(np.linalg.norm((ends[0] - ends[1]) / (2.0 * h) - change))

    h = 2e-3 / solid.order**2
    assert order_of(energy_error, h) == pytest.approx(2.0, abs=0.1)
    assert order_of(force_error, h) == pytest.approx(2.0, abs=0.1)
    assert force_error(1e-3 * h) < 1e-6 * np.linalg.norm(change)
    assert abs(tangent - tangent.T).max() < 1e-12 * abs(tangent).max()


@pytest.mark.parametrize("name", BODIES)
def test_a_turned_body_is_at_rest(name: str) -> None:
    solid = body(name)
    u = solid.points @ rotation().T + [1.0, -2.0, 0.5] - solid.points
    assert abs(solid.energy(u)) < 1e-10 * 1e5
    assert abs(solid.internal_force(u)).max() < 1e-10 * 1e5


@pytest.mark.parametrize("name", [n for n in BODIES if "mixed" not in n and "springs" not in n])
def test_patch_of_a_law_at_points(name: str) -> None:
    """F constant: ψ(F) V, and forces at the surface only, those of P."""
    solid = body(name)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.95, 0.1], [0.05, 0.0, 1.2]])
    u = solid.points @ (F - np.eye(3)).T
    law = BODIES[name][2]
    answer = law.respond(F[None], law.parameters)
    volume = solid.total_mass() / law.density
    assert solid.energy(u) == pytest.approx(answer.energy[0] * volume, rel=1e-12)
    force, inner = solid.internal_force(u), ~on_surface(solid)
    np.testing.assert_allclose(
        np.einsum("ni,nj->ij", force, solid.points),
        answer.stress[0] * volume,
        rtol=1e-10,
        atol=1e-6,
    )
    assert inner.any()
    assert abs(force[inner]).max() < 1e-12 * abs(force).max()


@pytest.mark.parametrize("kind", ["tetrahedron", "hexahedron"])
def test_laws_of_all_sorts_add_up(kind: str) -> None:
    """A mixed body has the forces of bodies in which one region after another is all but absent."""
    whole, soft = mixed(kind), {"poisson": 0.0, "density": 1e-8, "young": 1e-8}
    u, mesh_data = bend(whole, 0.2), whole.mesh_data
    absent = NeoHookean(**soft)
    laws: dict[Any, Any] = dict(whole.materials)  # type: ignore[arg-type]
    parts = [
        fem.Solid(
            mesh_data, {region: laws[region] if region == kept else absent for region in laws}
        )
        for kept in laws
    ]
    assert whole.energy(u) == pytest.approx(sum(p.energy(u) for p in parts), rel=1e-9)
    force, tangent = whole.internal_force(u), whole.tangent(u)
    assert abs(sum(p.internal_force(u) for p in parts) - force).max() < 1e-9 * abs(force).max()
    assert abs(sum(p.tangent(u) for p in parts) - tangent).max() < 1e-9 * abs(tangent).max()
    rest = sum(p.tangent() for p in parts) - whole.tangent()
    assert abs(rest).max() < 1e-9 * abs(tangent).max()


@pytest.mark.parametrize("law", [COROTATIONAL, Invertible(SVK), INVERTIBLE])
def test_modes_about_rest_are_those_of_linear_elasticity(law: Any) -> None:
    mesh_data = mesh_of(source("tetrahedron", mapping=tapered))
    own, linear = (
        fem.Solid(mesh_data, each, fixed=["x<1e-9"]) for each in (law, LinearElastic(**MODULI))
    )
    assert own.is_isotropic_at_rest
    assert abs(own.tangent() - linear.tangent()).max() < 1e-12 * abs(linear.tangent()).max()
    there = own.tangent(np.zeros_like(own.points))
    assert abs(there - linear.tangent()).max() < 1e-9 * abs(there).max()
    np.testing.assert_allclose(
        analysis.linear_modes(own, 4).frequencies, analysis.linear_modes(linear, 4).frequencies
    )


def test_modes_of_springs_come_from_their_own_tangent() -> None:
    mesh_data = mesh_of(source("tetrahedron"))
    solid = fem.Solid(mesh_data, SPRINGS, fixed=["x<1e-9"])
    assert not solid.is_isotropic_at_rest
    there = solid.tangent(np.zeros_like(solid.points))
    assert abs(solid.tangent() - there).max() < 1e-14 * abs(there).max()
    modes = analysis.linear_modes(solid, 3)
    free = ~solid.held.ravel()
    K, M = (A.toarray()[np.ix_(free, free)] for A in (solid.tangent(), solid.mass()))
    lowest = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[:3]
    np.testing.assert_allclose(modes.frequencies, np.sqrt(lowest) / (2.0 * np.pi), rtol=1e-6)


def test_springs_need_order_1() -> None:
    with pytest.raises(MaterialError, match="displacements of order 1, got order 2"):
        fem.Solid(mesh_of(source("tetrahedron")), SPRINGS, order=2)


def test_a_spring_of_no_length_pushes_nowhere() -> None:
    solid = bar("tetrahedron", 1, law=SPRINGS)
    local = -solid.space.tabulate_dof_coordinates()  # all nodes in one point
    assert np.isfinite(solid.assembly.energy(local))
    assert not solid.assembly.force(local).any()
    matrix = solid.assembly.stiffness_matrix(local)
    assert np.isfinite(matrix.norm())
    matrix.destroy()


@pytest.mark.parametrize("name", ["mixed tetrahedron", "corotational hexahedron 2"])
def test_a_matrix_is_refilled_in_place(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    solid = body(name)
    assembly = solid.assembly
    matrix = assembly.empty_matrix()
    states = [solid.nodes.scatter(bend(solid, size)) for size in (0.1, 0.2)]
    fresh = assembly.stiffness_matrix(states[1], diagonal=3.0)
    assembly.fill_tangent(matrix, states[0])
    assembly.force(states[0])

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a new matrix, or a new form")

    with monkeypatch.context() as patch:
        patch.setattr(fem.assembly.BlockMatrix, "empty", refuse)
        patch.setattr(fem.assembly, "compiled", refuse)
        patch.setattr(fem.ufl_part, "compiled", refuse)
        assembly.fill_tangent(matrix, states[1], diagonal=3.0)
        force = assembly.force(states[1])
    assert matrix.getInfo()["mallocs"] == 0
    matrix.axpy(-1.0, fresh, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    assert matrix.norm() < 1e-13 * fresh.norm()
    np.testing.assert_allclose(
        assembly.linearise(matrix, states[1], diagonal=3.0), force, atol=1e-13 * abs(force).max()
    )
    matrix.axpy(-1.0, fresh, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    assert matrix.norm() < 1e-13 * fresh.norm()
    matrix.destroy()
    fresh.destroy()


def test_other_components_can_be_held() -> None:
    mesh_data = mesh_of(source("tetrahedron"))
    free, fixed = fem.Solid(mesh_data, NEO), fem.Solid(mesh_data, NEO, fixed=["x<1e-9"])
    u = free.nodes.scatter(bend(free))
    matrices = [
        assembly.stiffness_matrix(u, diagonal=2.0)
        for assembly in (fixed.assembly, free.assembly.with_held(free.nodes.scatter(fixed.held)))
    ]
    assert matrices[0].equal(matrices[1])
    for matrix in matrices:
        matrix.destroy()


def test_nan_is_not_lost_in_the_kernels() -> None:
    """The compiler's freedom to reorder sums does not go so far as to forget NaN."""
    for law in (NEO, SVK, COROTATIONAL, SPRINGS):
        solid = bar("tetrahedron", 1, law=law)
        local = solid.nodes.scatter(bend(solid))
        local[3, 1] = np.nan
        assert np.isnan(solid.assembly.energy(local))
        assert np.isnan(solid.assembly.force(local)[3]).any()
        with np.errstate(all="ignore"):
            matrix = solid.assembly.stiffness_matrix(local)
        assert np.isnan(matrix.norm())
        matrix.destroy()
