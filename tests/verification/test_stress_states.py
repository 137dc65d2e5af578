"""Homogeneous states of stress: what the nodes of a body must feel, from the laws' closed forms."""

from collections.abc import Callable

import numpy as np
import pytest
from bodies import Array, box_arrays
from scipy.optimize import brentq

from fenics_defo.energy import (
    LinearElastic,
    Material,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.fem import Solid, build_mesh

YOUNG, POISSON, MU, LMBDA = 2.6, 0.3, 1.0, 1.5
C10, C01, BULK = 0.3, 0.2, 4.0
SIDES = np.array([1.0, 0.8, 0.6])
AREA = SIDES[1] * SIDES[2]
CENTRE = SIDES / 2.0


def linear_stress(F: Array) -> Array:
    strain = 0.5 * (F + F.T) - np.eye(3)
    return LMBDA * np.trace(strain) * np.eye(3) + 2.0 * MU * strain


def st_venant_kirchhoff_stress(F: Array) -> Array:
    strain = 0.5 * (F.T @ F - np.eye(3))
    return F @ (LMBDA * np.trace(strain) * np.eye(3) + 2.0 * MU * strain)


def neo_hookean_stress(F: Array) -> Array:
    inverse = np.linalg.inv(F).T
    return MU * (F - inverse) + LMBDA * np.log(np.linalg.det(F)) * inverse


def mooney_rivlin_stress(F: Array) -> Array:
    """From dI1/dF = 2 F, dI2/dF = 2 (I1 F - F C), dJ/dF = J F^-T."""
    C, J, inverse = F.T @ F, np.linalg.det(F), np.linalg.inv(F).T
    I1 = np.trace(C)
    I2 = 0.5 * (I1**2 - np.trace(C @ C))
    return (
        2.0 * C10 * J ** (-2.0 / 3.0) * (F - I1 / 3.0 * inverse)
        + 2.0 * C01 * J ** (-4.0 / 3.0) * (I1 * F - F @ C - 2.0 / 3.0 * I2 * inverse)
        + BULK * (J - 1.0) * J * inverse
    )


TWO_MODULI = {"young": YOUNG, "poisson": POISSON, "density": 1.0}
LAWS = [
    pytest.param(LinearElastic(**TWO_MODULI), linear_stress, id="linear"),
    pytest.param(StVenantKirchhoff(**TWO_MODULI), st_venant_kirchhoff_stress, id="stvk"),
    pytest.param(NeoHookean(**TWO_MODULI), neo_hookean_stress, id="neo-hookean"),
    pytest.param(
        MooneyRivlin(c10=C10, c01=C01, bulk=BULK, density=1.0),
        mooney_rivlin_stress,
        id="mooney-rivlin",
    ),
]
SPACES = [("tetrahedron", 2), ("hexahedron", 1)]

type Stress = Callable[[Array], Array]

GENERAL = np.array([[1.2, 0.3, -0.1], [0.05, 0.85, 0.2], [-0.15, 0.1, 1.1]])


def shear(amount: float) -> Array:
    F = np.eye(3)
    F[0, 1] = amount
    return F


def uneven_body(material: Material, kind: str, order: int) -> Solid:
    """A box whose inner nodes are pushed about, so that no two cells are alike."""
    points, cells = box_arrays(kind, (3, 3, 3), SIDES)
    inner = ((points > 1e-9) & (points < SIDES - 1e-9)).all(axis=1)
    points[inner] += 0.05 * np.random.default_rng(1).uniform(-1.0, 1.0, (inner.sum(), 3))
    return Solid(build_mesh(points, cells, kind=kind), material, order=order)


def displaced(solid: Solid, F: Array) -> Array:
    return (solid.points - CENTRE) @ (F - np.eye(3)).T


def on_boundary(solid: Solid) -> np.ndarray:
    return ((solid.points < 1e-9) | (solid.points > SIDES - 1e-9)).any(axis=1)


@pytest.mark.parametrize(("kind", "order"), SPACES)
@pytest.mark.parametrize(("material", "stress"), LAWS)
@pytest.mark.parametrize("F", [GENERAL, shear(0.7)], ids=["general", "shear"])
def test_patch(material: Material, stress: Stress, kind: str, order: int, F: Array) -> None:
    """Patch test at finite strain: no force inside, and sum f ⊗ X = V P by virtual work."""
    solid = uneven_body(material, kind, order)
    force = solid.internal_force(displaced(solid, F))
    scale = np.abs(stress(F)).max() * AREA
    assert np.abs(force[~on_boundary(solid)]).max() < 1e-12 * scale
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * scale
    assert force.T @ solid.points / SIDES.prod() == pytest.approx(stress(F), abs=1e-11 * scale)


@pytest.mark.parametrize(("material", "stress"), LAWS)
@pytest.mark.parametrize("F", [GENERAL, shear(0.7)], ids=["general", "shear"])
def test_corners_of_one_hexahedron(material: Material, stress: Stress, F: Array) -> None:
    """Each corner bears a quarter of the force P N A on each of its three faces."""
    points, cells = box_arrays("hexahedron", (1, 1, 1), SIDES)
    solid = Solid(build_mesh(points, cells, kind="hexahedron"), material, order=1)
    outward = np.where(solid.points > CENTRE, 1.0, -1.0) * SIDES.prod() / SIDES
    expected = 0.25 * outward @ stress(F).T
    assert solid.internal_force(displaced(solid, F)) == pytest.approx(
        expected, rel=1e-11, abs=1e-13
    )


def uniaxial_stretch(stress: Stress, stretch: float) -> Array:
    """F with the lateral stretch that leaves the sides free of traction."""

    def side(lateral: float) -> float:
        return float(stress(np.diag([stretch, lateral, lateral]))[1, 1])

    lateral = brentq(side, 0.5, 1.5, xtol=1e-15, rtol=1e-14)
    return np.diag([stretch, lateral, lateral])


@pytest.mark.parametrize(("kind", "order"), SPACES)
@pytest.mark.parametrize(("material", "stress"), LAWS)
@pytest.mark.parametrize("stretch", [0.8, 1.5])
def test_bar_in_tension(
    material: Material, stress: Stress, kind: str, order: int, stretch: float
) -> None:
    """A bar with free sides: its ends feel nominal stress times area, all other nodes nothing."""
    solid = uneven_body(material, kind, order)
    F = uniaxial_stretch(stress, stretch)
    force = solid.internal_force(displaced(solid, F))
    pull = stress(F)[0, 0] * AREA
    end = solid.points[:, 0] > 1.0 - 1e-9
    assert force[end].sum(axis=0) == pytest.approx([pull, 0.0, 0.0], rel=1e-11, abs=1e-12)
    sides = (solid.points[:, 0] > 1e-9) & ~end
    assert np.abs(force[sides]).max() < 1e-12


def test_uniaxial_closed_forms() -> None:
    """The references above against textbook formulas that need no root.

    St. Venant-Kirchhoff: P = E s (s² - 1) / 2; linear: P = E (s - 1); neo-Hookean with the lateral
    stretch t: P = μ (s - t² / s), from μ (t² - 1) + λ ln J = 0.
    """
    for s in (0.8, 1.5):
        F = uniaxial_stretch(st_venant_kirchhoff_stress, s)
        assert st_venant_kirchhoff_stress(F)[0, 0] == pytest.approx(YOUNG * s * (s**2 - 1.0) / 2.0)
        F = uniaxial_stretch(linear_stress, s)
        assert linear_stress(F)[0, 0] == pytest.approx(YOUNG * (s - 1.0))
        F = uniaxial_stretch(neo_hookean_stress, s)
        assert neo_hookean_stress(F)[0, 0] == pytest.approx(MU * (s - F[1, 1] ** 2 / s))


@pytest.mark.parametrize("amount", [0.4, 1.0])
def test_simple_shear_needs_normal_stress(amount: float) -> None:
    """Simple shear by γ, textbook: P12 = μγ and P22 = 0 (neo-Hookean), P12 = μγ, P22 = 0 (linear),
    P12 = μγ + (λ/2 + μ) γ³ and P22 = (λ/2 + μ) γ² (St. Venant-Kirchhoff: normal stress)."""
    stiff = (0.5 * LMBDA + MU) * amount**2
    rows = [
        (LinearElastic, MU * amount, 0.0),
        (NeoHookean, MU * amount, 0.0),
        (StVenantKirchhoff, (MU + stiff) * amount, stiff),
    ]
    for law, expected_shear, expected_normal in rows:
        solid = uneven_body(law(**TWO_MODULI), "tetrahedron", 2)
        virial = solid.internal_force(displaced(solid, shear(amount))).T @ solid.points
        stress = virial / SIDES.prod()
        assert stress[0, 1] == pytest.approx(expected_shear, rel=1e-11)
        assert stress[1, 1] == pytest.approx(expected_normal, abs=1e-11)
