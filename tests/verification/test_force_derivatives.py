"""Energy, force and tangent of a bent body: objective, and each the derivative of the one before.

A straight symmetric beam hides errors in quadratic terms, because they vanish there.
"""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from bodies import Array, box, drawn, orders
from scipy import sparse
from scipy.spatial.transform import Rotation

from fenics_defo.energy import (
    LinearElastic,
    Material,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.fem import ImportedMesh, Solid, build_mesh
from meshes.bent_beam import bent_beam

TWO_MODULI = {"young": 2.6, "poisson": 0.3, "density": 1.0}
STVK = StVenantKirchhoff(**TWO_MODULI)
OBJECTIVE = [
    pytest.param(STVK, id="stvk"),
    pytest.param(NeoHookean(**TWO_MODULI), id="neo-hookean"),
    pytest.param(MooneyRivlin(c10=0.3, c01=0.2, bulk=4.0, density=1.0), id="mooney-rivlin"),
]
TURN = Rotation.from_rotvec([0.9, -1.7, 0.6]).as_matrix()
SHIFT = np.array([3.0, -1.0, 2.0])


@pytest.fixture(scope="module")
def bent(tmp_path_factory: pytest.TempPathFactory) -> ImportedMesh:
    return drawn(bent_beam, Path(tmp_path_factory.mktemp("bent")), size=0.1, order=2)


def smooth(solid: Solid, seed: int) -> Array:
    """A displacement of random waves, about as long as the body, with |grad u| of about 0.1."""
    rng = np.random.default_rng(seed)
    waves, phases = rng.uniform(2.0, 8.0, (3, 3)), rng.uniform(0.0, 6.0, 3)
    return 0.015 * np.sin(solid.points @ waves + phases)


def carried(solid: Solid, displacement: Array) -> Array:
    """The displacement after the deformed body has been turned and shifted."""
    return (solid.points + displacement) @ TURN.T + SHIFT - solid.points


@pytest.mark.parametrize("material", OBJECTIVE)
def test_rigid_motion_costs_nothing(material: Material, bent: ImportedMesh) -> None:
    """ψ(Q F) = ψ(F): a moved body stores the same energy, and the forces turn with it."""
    solid = Solid(bent, material, order=2)
    u = smooth(solid, 1)
    energy, force = solid.energy(u), solid.internal_force(u)
    rigid = carried(solid, np.zeros_like(u))
    assert abs(solid.energy(rigid)) < 1e-12 * energy
    assert np.abs(solid.internal_force(rigid)).max() < 1e-11 * np.abs(force).max()
    assert solid.energy(carried(solid, u)) == pytest.approx(energy, rel=1e-11)
    turned = solid.internal_force(carried(solid, u))
    assert turned == pytest.approx(force @ TURN.T, abs=1e-10 * np.abs(force).max())


@pytest.mark.parametrize("material", OBJECTIVE)
def test_no_net_force_nor_moment(material: Material, bent: ImportedMesh) -> None:
    """Noether: an objective energy gives forces in balance, moments taken in the deformed shape."""
    solid = Solid(bent, material, order=2)
    u = smooth(solid, 1)
    force = solid.internal_force(u)
    arms = solid.points + u
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()
    assert np.abs(np.cross(arms, force).sum(axis=0)).max() < 1e-12 * np.abs(force).sum()


def test_linear_law_resists_rotation(bent: ImportedMesh) -> None:
    """Linear elasticity is not objective: rotation by θ stores (μ + λ) 2 (1 - cos θ)² V, O(θ⁴).

    About one axis ε = diag(cos θ - 1, cos θ - 1, 0), so ψ = (λ/2 4 + μ 2) (1 - cos θ)².
    """
    solid = Solid(bent, LinearElastic(**TWO_MODULI), order=2)
    volume = solid.total_mass()
    energies = []
    for angle in (0.2, 0.1):
        turn = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
        energies.append(solid.energy(solid.points @ (turn - np.eye(3)).T))
        expected = 2.0 * (1.5 + 1.0) * (1.0 - np.cos(angle)) ** 2 * volume
        assert energies[-1] == pytest.approx(expected, rel=1e-9)
    assert orders(energies)[0] == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize("material", OBJECTIVE)
def test_derivatives_by_central_differences(material: Material, bent: ImportedMesh) -> None:
    """(E(u + hv) - E(u - hv)) / 2h -> f·v and (f(u + hv) - f(u - hv)) / 2h -> K v with h²."""
    solid = Solid(bent, material, order=2)
    u, v = smooth(solid, 1), smooth(solid, 2)
    slope = float(np.vdot(solid.internal_force(u), v))
    product = (solid.tangent(u) @ v.ravel()).reshape(v.shape)
    first, second = [], []
    for h in (0.4, 0.2, 0.1):
        ahead, behind = u + h * v, u - h * v
        first.append((solid.energy(ahead) - solid.energy(behind)) / (2.0 * h) - slope)
        change = (solid.internal_force(ahead) - solid.internal_force(behind)) / (2.0 * h)
        second.append(np.linalg.norm(change - product))
    assert orders(first) == pytest.approx(2.0, abs=0.1)
    assert orders(second) == pytest.approx(2.0, abs=0.1)
    assert abs(first[-1]) < 0.02 * solid.energy(u)
    assert second[-1] < 0.02 * np.linalg.norm(product)


def test_st_venant_kirchhoff_force_is_cubic(bent: ImportedMesh) -> None:
    """f(t v) = t a + t² b + t³ c exactly, a = K(0) v: four amplitudes give the fifth."""
    solid = Solid(bent, STVK, order=2)
    v = smooth(solid, 2)
    amplitudes = np.array([-2.0, -1.0, 1.0, 2.0])
    forces = np.array([solid.internal_force(t * v).ravel() for t in amplitudes])
    parts = np.linalg.lstsq(amplitudes[:, None] ** np.arange(1, 4), forces, rcond=None)[0]
    scale = np.abs(forces).max()
    assert parts[0] == pytest.approx(solid.tangent() @ v.ravel(), abs=1e-12 * scale)
    predicted = 3.5 ** np.arange(1, 4) @ parts
    assert solid.internal_force(3.5 * v).ravel() == pytest.approx(predicted, abs=1e-11 * scale)
    assert np.abs(parts[1]).max() > 0.05 * np.abs(parts[0]).max()


def directional(solid: Solid, along: Array) -> sparse.csr_array:
    """DK(0)[v]: exact for St. Venant-Kirchhoff, whose tangent is quadratic in the displacement."""
    return 0.5 * (solid.tangent(along) - solid.tangent(-along))


def test_third_derivative_is_symmetric(bent: ImportedMesh) -> None:
    """E'''[u, v, w] is the same in all six orders: the quadratic force has a potential too."""
    solid = Solid(bent, STVK, order=2)
    fields = [smooth(solid, seed) for seed in (1, 2, 3)]
    derivatives = [directional(solid, field) for field in fields]
    flat = [field.ravel() for field in fields]
    values = [flat[i] @ derivatives[j] @ flat[k] for i, j, k in permutations(range(3))]
    assert values == pytest.approx(np.full(6, values[0]), rel=1e-10)
    assert abs(derivatives[0] - derivatives[0].T).max() < 1e-13 * abs(derivatives[0]).max()


def test_quadratic_term_of_bent_and_straight() -> None:
    """E'''[b, b, b] of bending b: zero by mirror symmetry in a straight beam, not in a sickle."""
    straight = Solid(box("hexahedron", (8, 2, 2), (0.8, 0.1, 0.1)), STVK, order=1)
    x, z = straight.points[:, 0], straight.points[:, 2] - 0.05
    bending = np.stack([-2.0 * z * x, 0.0 * x, x**2], axis=1)
    points = straight.points.copy()
    points[:, 2] += 0.3 * x**2  # a sickle: the same cells, sheared to follow a parabola
    sickle = Solid(build_mesh(points, straight.cells, kind="hexahedron"), STVK, order=1)
    cubic = [
        abs(bending.ravel() @ directional(solid, bending) @ bending.ravel())
        for solid in (straight, sickle)
    ]
    stiff = bending.ravel() @ straight.tangent() @ bending.ravel()
    assert cubic[0] < 1e-12 * stiff
    assert cubic[1] > 0.1 * stiff
