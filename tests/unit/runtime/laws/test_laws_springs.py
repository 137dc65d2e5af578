"""Springs of cells: as stiff as the isotropic solid of Poisson's ratio 1/4."""

import numpy as np
import pytest
from law_points import hooke, rotations

from fenics_defo.runtime.laws import cell_springs

YOUNG = 3.0
CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
SHAPES = {"tetrahedron": TETRAHEDRON, "hexahedron": CUBE}


def moduli(points, springs):
    """Σ k L² n⊗n⊗n⊗n, the second derivative of the energy in a uniform small strain."""
    n = (points[springs.ends[:, 1]] - points[springs.ends[:, 0]]) / springs.length[:, None]
    return np.einsum("e,ei,ej,ek,el->ijkl", springs.stiffness * springs.length**2, n, n, n, n)


def solid_moduli(young):
    """Of E and ν = 1/4: λ = μ = 2E/5."""
    return hooke(0.4 * young, 0.4 * young)


def volume(corners):
    """By the divergence theorem over the faces, each split into four triangles about its mean."""
    faces = ([0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5])
    total = 0.0
    for face in faces:
        x = corners[face]
        for a, b in zip(x, np.roll(x, -1, axis=0), strict=True):
            total += np.linalg.det([a, b, x.mean(axis=0)]) / 6
    return total


def test_a_cube_is_as_stiff_as_the_solid_under_every_strain():
    springs = cell_springs(2.5 * CUBE, np.arange(8)[None], YOUNG)
    np.testing.assert_allclose(
        moduli(2.5 * CUBE, springs) / 2.5**3, solid_moduli(YOUNG), atol=1e-13
    )


def test_tetrahedra_of_all_directions_are_as_stiff_as_the_solid():
    Q = rotations(20000, 3)
    single = moduli(TETRAHEDRON, cell_springs(TETRAHEDRON, np.arange(4)[None], YOUNG))
    mean = np.einsum("mia,mjb,mkc,mld,abcd->ijkl", Q, Q, Q, Q, single, optimize=True) / len(Q)
    np.testing.assert_allclose(mean / (8 / 3), solid_moduli(YOUNG), atol=0.02 * YOUNG)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_cell_has_the_bulk_modulus_of_the_solid(shape):
    corners = SHAPES[shape] + 0.2 * np.random.default_rng(0).uniform(-1, 1, SHAPES[shape].shape)
    springs = cell_springs(corners, np.arange(len(corners))[None], YOUNG)
    content = (
        volume(corners)
        if shape == "hexahedron"
        else (abs(np.linalg.det(corners[1:] - corners[0])) / 6)
    )
    trace = np.einsum("iijj", moduli(corners, springs))
    assert trace == pytest.approx(np.einsum("iijj", solid_moduli(YOUNG)) * content, rel=1e-12)


def test_a_regular_tetrahedron_is_near_the_published_stiffness():
    """k = 2√2/25 L E of Lloyd, Szekely and Harders (2007), who matched another set of strains."""
    springs = cell_springs(TETRAHEDRON, np.arange(4)[None], YOUNG)
    published = 2 * np.sqrt(2) / 25 * springs.length * YOUNG
    np.testing.assert_allclose(springs.stiffness, published, rtol=0.05)


@pytest.mark.parametrize("shape", SHAPES)
def test_neighbours_share_springs_and_parts_add_up(shape):
    single = SHAPES[shape]
    count = len(single)
    points = np.concatenate([single, single + 10.0 + np.arange(count)[:, None] / 7])
    cells = np.array([np.arange(count), np.arange(count)[::-1], count + np.arange(count)])
    young = np.array([1.0, 2.0, 4.0])
    if shape == "hexahedron":
        cells = cells[[0, 2]]
        young = young[[0, 2]]
    whole = cell_springs(points, cells, young)
    assert len(np.unique(whole.ends, axis=0)) == len(whole.ends)
    assert (whole.ends[:, 0] < whole.ends[:, 1]).all()
    total = {tuple(ends): k for ends, k in zip(whole.ends, whole.stiffness, strict=True)}
    for cell, modulus in zip(cells, young, strict=True):
        part = cell_springs(points, cell[None], modulus)
        for ends, k in zip(part.ends, part.stiffness, strict=True):
            total[tuple(ends)] -= k
    np.testing.assert_allclose(list(total.values()), 0.0, atol=1e-13)


def test_no_cells_give_no_springs():
    springs = cell_springs(CUBE, np.empty((0, 8), dtype=np.int32), YOUNG)
    assert springs.ends.shape == (0, 2)
    assert springs.length.shape == springs.stiffness.shape == (0,)
