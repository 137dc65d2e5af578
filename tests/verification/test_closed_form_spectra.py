"""Bodies whose vibrations have closed forms in three dimensions, or even on the mesh.

A body between frictionless walls (no normal displacement, no shear stress) vibrates in products of
sines and cosines: with a wave vector k the frequency is |k| c / 2 pi, c the speed of pressure waves
if the motion is along k, of shear waves if it is across.
"""

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from bodies import EVERYWHERE, Array, box, orders
from numpy.typing import NDArray

from fenics_defo.analysis import linear_modes
from fenics_defo.beams import RectangularSection, Segment, stepped_axial_frequencies
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Fixed, Solid

KINDS = ("tetrahedron", "hexahedron")
SOLID = StVenantKirchhoff.from_lame(mu=1.0, lmbda=1.7, density=1.3)
PRESSURE_SPEED, SHEAR_SPEED = np.sqrt(3.7 / 1.3), np.sqrt(1.0 / 1.3)

SIDES = np.array([1.0, 0.83, 0.71])
WALLS = [Fixed(f"{c}=={at}", c) for c, side in zip("xyz", SIDES, strict=True) for at in (0.0, side)]


def wave(points: Array, waves: NDArray[np.int64], along: Array) -> Array:
    """u_i = d_i sin(k_i x_i) cos(k_j x_j) cos(k_l x_l) with k = pi waves / sides."""
    phase = np.pi * waves / SIDES * points
    field = np.empty_like(points)
    for i in range(3):
        others = np.delete(np.cos(phase), i, axis=1).prod(axis=1)
        field[:, i] = along[i] * np.sin(phase[:, i]) * others
    return field


def walled_spectrum() -> list[tuple[float, NDArray[np.int64], Array]]:
    """Frequency [Hz], wave numbers and polarisations (3, p) of the box's modes, ascending."""
    found = []
    for waves in product(range(4), repeat=3):
        k = np.array(waves) / SIDES / 2.0
        moving = k > 0.0
        if not moving.any():
            continue
        along = k / np.linalg.norm(k)
        found.append((PRESSURE_SPEED * np.linalg.norm(k), np.array(waves), along[:, None]))
        across = np.linalg.svd(along[None, moving])[2][1:]
        if len(across):
            directions = np.zeros((3, len(across)))
            directions[moving] = across.T
            found.append((SHEAR_SPEED * np.linalg.norm(k), np.array(waves), directions))
    return sorted(found, key=lambda mode: mode[0])


def tracked_errors(kind: str, order: int, cells: int) -> Array:
    """Relative errors of λ of the box's lowest modes, known by their shapes: errors swap them."""
    solid = Solid(box(kind, (cells,) * 3, SIDES), SOLID, order=order, fixed=WALLS)
    modes = linear_modes(solid, 10)
    mass = solid.mass()
    errors = []
    for frequency, waves, directions in walled_spectrum()[:5]:
        shapes = np.array([wave(solid.points, waves, along).ravel() for along in directions.T])
        shapes /= np.sqrt(np.einsum("in,in->i", shapes, (mass @ shapes.T).T))[:, None]
        overlap = modes.shapes.reshape(10, -1) @ mass @ shapes.T
        chosen = np.sort(np.argsort((overlap**2).sum(axis=1))[-len(shapes) :])
        assert np.linalg.svd(overlap[chosen], compute_uv=False).min() > 0.99
        errors.append(modes.frequencies[chosen] ** 2 / frequency**2 - 1.0)
    return np.concatenate(errors)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("order", "coarse"), [(1, 6), (2, 3)])
def test_box_between_walls(kind: str, order: int, coarse: int) -> None:
    """λ_h - λ = O(h^2p), from above, for pressure and shear modes alike.

    Strang and Fix, An Analysis of the Finite Element Method (1973), chapter 6.
    """
    errors = [tracked_errors(kind, order, coarse), tracked_errors(kind, order, 2 * coarse)]
    assert (errors[1] > 0.0).all()
    assert orders(errors) == pytest.approx(np.full((1, 6), 2.0 * order), abs=0.3 * order)


def linear_dispersion(phase: Array) -> Array:
    """(omega h / c)² of waves of ``phase`` = k h on equal linear elements with consistent mass."""
    return 6.0 * (1.0 - np.cos(phase)) / (2.0 + np.cos(phase))


def quadratic_dispersion(phase: Array) -> Array:
    """The same for quadratic elements of the length h, mid nodes eliminated: the lower root L of
    cos(kh) = (3 L² - 104 L + 240) / (L² + 16 L + 240)."""
    cosine = np.cos(phase)
    a, b, c = 3.0 - cosine, 104.0 + 16.0 * cosine, 240.0 * (1.0 - cosine)
    return (b - np.sqrt(b**2 - 4.0 * a * c)) / (2.0 * a)


# Columns of hexahedra whose nodes move along one axis only: along the column or across it.
@pytest.mark.parametrize(
    ("moving", "speed"), [("x", PRESSURE_SPEED), ("y", SHEAR_SPEED)], ids=["pressure", "shear"]
)
@pytest.mark.parametrize(
    ("order", "dispersion"), [(1, linear_dispersion), (2, quadratic_dispersion)]
)
def test_column_obeys_the_mesh_dispersion(
    moving: str, speed: float, order: int, dispersion: Callable[[Array], Array]
) -> None:
    """Not only the order but the error itself: the known dispersion of elements, to round-off."""
    length, cells, count = 2.0, 12, 6
    still = "xyz".replace(moving, "")
    solid = Solid(
        box("hexahedron", (cells, 1, 1), (length, 0.1, 0.1)),
        SOLID,
        order=order,
        fixed=[Fixed(EVERYWHERE, still), Fixed("x==0")],
    )
    k = (np.arange(count) + 0.5) * np.pi / length
    h = length / cells
    expected = np.sqrt(dispersion(k * h)) * speed / h / (2.0 * np.pi)
    assert linear_modes(solid, count).frequencies == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_column_of_two_materials(kind: str) -> None:
    """Order 4 across an interface between cells; reference: bars whose modulus is λ + 2μ."""
    other = StVenantKirchhoff.from_lame(mu=0.4, lmbda=0.3, density=0.5)
    section = RectangularSection(0.25, 0.25)
    moduli = ((3.7, 1.3, 1.25), (1.1, 0.5, 0.75))  # λ + 2μ, density, length
    bars = [
        Segment(length=length, section=section, young=m, poisson=0.0, density=density)
        for m, density, length in moduli
    ]
    expected = stepped_axial_frequencies(bars, count=4)
    errors = []
    for cells in (8, 16):
        solid = Solid(
            box(kind, (cells, 1, 1), (2.0, 0.25, 0.25)),
            {"x<1.25": SOLID, "x>1.25": other},
            order=2,
            fixed=[Fixed(EVERYWHERE, "yz"), Fixed("x==0")],
        )
        errors.append(linear_modes(solid, 4).frequencies / expected - 1.0)
    assert np.abs(errors[1]).max() < 4e-4
    assert orders(errors) == pytest.approx(np.full((1, 4), 4.0), abs=0.4)
