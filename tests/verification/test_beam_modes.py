"""Slender bodies against beam theory, and how the four spaces approach it.

Theory and solid differ where the theory stops: a clamp that holds the lateral contraction stiffens
the solid by about half a percent at this slenderness, one that holds the warping stiffens torsion
by about one; free ends do neither.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from bodies import Array, box, drawn, orders, richardson_order

from fenics_defo.analysis import describe_motion, linear_modes
from fenics_defo.beams import (
    RectangularSection,
    Segment,
    axial_frequencies,
    bending_roots,
    cantilever_spectrum,
    stepped_axial_frequencies,
    stepped_bending_frequencies,
    stepped_torsional_frequencies,
    timoshenko_frequencies,
    torsional_frequencies,
)
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Solid
from fenics_defo.runtime import Modes
from meshes.two_material_beam import two_material_beam

KINDS = ("tetrahedron", "hexahedron")
STEEL = {"young": 2.0e11, "poisson": 0.3, "density": 7800.0}
ALUMINIUM = {"young": 7.0e10, "poisson": 0.33, "density": 2700.0}
LENGTH, WIDTH, HEIGHT = 1.0, 0.1, 0.08
SECTION = RectangularSection(WIDTH, HEIGHT)
BAR = {"length": LENGTH, "section": SECTION, **STEEL}
# The coefficient for vibration; Cowper's differs by less than 0.2 % in the frequencies here.
SHEAR = "timoshenko"


@cache
def bar_modes(kind: str, order: int, finer: int, *, clamped: bool, count: int) -> Modes:
    """Modes of the steel bar, 10 ``finer`` cells long and ``finer`` cells thick."""
    mesh = box(kind, (10 * finer, finer, finer), (LENGTH, WIDTH, HEIGHT))
    solid = Solid(mesh, StVenantKirchhoff(**STEEL), order=order, fixed=["x==0"] if clamped else [])
    return linear_modes(solid, count)


def cantilever(kind: str, order: int, finer: int) -> Modes:
    return bar_modes(kind, order, finer, clamped=True, count=8)


def free_bar(finer: int) -> Modes:
    return bar_modes("hexahedron", 2, finer, clamped=False, count=14)


def excess(modes: Modes, word: str, expected: Array) -> Array:
    """Relative excess over theory of the modes that move as ``word`` says."""
    found = modes.frequencies[[w == word for w in describe_motion(modes)]]
    assert len(found) >= len(expected), f"{len(found)} modes of {word!r}"
    return found[: len(expected)] / expected - 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_cantilever_spectrum(kind: str) -> None:
    """Bending in both planes, torsion and extension within the clamp's effect, from above."""
    modes, theory = cantilever(kind, 2, 2), cantilever_spectrum(count=3, shear=SHEAR, **BAR)
    bounds = {
        "bending y": (theory.bending_y, 0.015),
        "bending z": (theory.bending_z, 0.015),
        "torsion": (theory.torsion[:1], 0.04),
        "axial": (theory.axial[:1], 0.007),
    }
    for word, (expected, bound) in bounds.items():
        errors = excess(modes, word, expected)
        assert (errors > 0.0).all(), word
        assert (errors < bound).all(), word


@pytest.mark.parametrize("kind", KINDS)
def test_frequencies_fall_with_refinement(kind: str) -> None:
    """Courant's min-max law: a larger space lowers every frequency; order 2 contains order 1."""
    first = np.array([cantilever(kind, 1, finer).frequencies[:8] for finer in (1, 2, 4)])
    second = np.array([cantilever(kind, 2, finer).frequencies[:8] for finer in (1, 2)])
    assert (np.diff(first, axis=0) < 0.0).all()
    assert (np.diff(second, axis=0) < 0.0).all()
    assert (second < first[:2]).all()
    assert (second[1] < first[2]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_first_order_locks(kind: str) -> None:
    """Order 1 is far too stiff in bending, tetrahedra most; order 2 on the coarsest mesh is not."""
    limit = cantilever("hexahedron", 2, 2).frequencies[:2]
    errors = [cantilever(kind, 1, finer).frequencies[:2] / limit - 1.0 for finer in (1, 2, 4)]
    one, four = (0.6, 0.1) if kind == "tetrahedron" else (0.2, 0.015)
    assert (errors[0] > one).all()
    assert (errors[2] > four).all()
    assert orders(errors)[1] == pytest.approx(2.0, abs=0.5)
    assert (np.abs(cantilever(kind, 2, 1).frequencies[:2] / limit - 1.0) < 0.025).all()


def test_free_bar_is_rigid_six_times() -> None:
    """Six motions without energy span all rigid ones; the others have no momentum of any kind."""
    modes = free_bar(2)
    assert modes.rigid_modes == 6
    own = modes.participation**2 / modes.inertia
    assert own[:6].sum(axis=0) == pytest.approx(np.ones(6), rel=1e-9)
    assert own[6:].max() < 1e-12
    mesh = box("hexahedron", (20, 2, 2), (LENGTH, WIDTH, HEIGHT))
    solid = Solid(mesh, StVenantKirchhoff(**STEEL), order=2)
    shapes = modes.shapes.reshape(len(modes.shapes), -1)
    stiffness = np.einsum("ki,ki->k", shapes, (solid.tangent() @ shapes.T).T)
    assert np.abs(stiffness[:6]).max() < 1e-8 * stiffness[6]


def test_free_bar_spectrum() -> None:
    """Free ends do not disturb: Timoshenko to 0.2 %, and Rayleigh's and Love's lateral inertia.

    Love, Mathematical Theory of Elasticity, section 278: an extension wave of the number k has
    f = f0 (1 - ν² k² I_p / 2A).
    """
    modes = free_bar(2)
    for word, direction in (("bending y", "y"), ("bending z", "z")):
        theory = timoshenko_frequencies(
            count=2, supports="free-free", direction=direction, shear=SHEAR, **BAR
        )
        assert np.abs(excess(modes, word, theory)).max() < 0.002
    torsion = torsional_frequencies(count=1, ends="free-free", **BAR)
    assert excess(modes, "torsion", torsion)[0] == pytest.approx(0.0, abs=0.015)
    bar = axial_frequencies(length=LENGTH, young=2.0e11, density=7800.0, count=1, ends="free-free")
    gyration = SECTION.polar_moment / SECTION.area
    lateral = -0.5 * 0.3**2 * (np.pi / LENGTH) ** 2 * gyration
    assert excess(modes, "axial", bar)[0] == pytest.approx(lateral, rel=0.05)


BLOCK = (2.4, 0.8, 1.0)


@cache
def block_values(kind: str, order: int, finer: int) -> Array:
    """ω² / 4π² of the two lowest bending modes of a free block."""
    mesh = box(kind, (3 * finer, finer, finer), BLOCK)
    material = StVenantKirchhoff(young=1.0, poisson=0.3, density=1.0)
    return linear_modes(Solid(mesh, material, order=order), 8).frequencies[6:8] ** 2


def test_free_block_converges_with_its_own_limit() -> None:
    """λ_h - λ_{h/2} falls by 2⁴ at order 2: convex edges that are free have no singularity."""
    values = [block_values("hexahedron", 2, finer) for finer in (1, 2, 4)]
    assert richardson_order(values) == pytest.approx(np.full(2, 4.0), abs=0.7)


@pytest.mark.parametrize(
    ("kind", "order"), [("hexahedron", 1), ("tetrahedron", 1), ("tetrahedron", 2)]
)
def test_spaces_share_the_limit_of_a_free_block(kind: str, order: int) -> None:
    """The other spaces tend to the extrapolated limit of second-order hexahedra, with order 2p."""
    middle, fine = (block_values("hexahedron", 2, finer) for finer in (2, 4))
    limit = fine + (fine - middle) / 15.0
    errors = [block_values(kind, order, finer) / limit - 1.0 for finer in (2, 4)]
    assert (errors[1] > 0.0).all()
    assert orders(errors)[0] == pytest.approx(np.full(2, 2.0 * order), abs=0.4 * order)


def bending_field(points: Array, axis: int, root: float) -> Array:
    """Clamped-free bending of a slender bar along x: w(x) sideways, -(distance) w'(x) along."""
    b, x = root / LENGTH, points[:, 0]
    ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
    w = np.cosh(b * x) - np.cos(b * x) - ratio * (np.sinh(b * x) - np.sin(b * x))
    slope = b * (np.sinh(b * x) + np.sin(b * x) - ratio * (np.cosh(b * x) - np.cos(b * x)))
    field = np.zeros_like(points)
    field[:, axis] = w
    field[:, 0] = -(points[:, axis] - points[:, axis].mean()) * slope
    return field


@pytest.mark.parametrize("kind", KINDS)
def test_pairs_of_a_square_bar_are_one_space(kind: str) -> None:
    """A square bar bends in any plane: each pair spans the two analytic shapes, whatever its turn.

    Where the mesh is square too the frequencies are equal, and the modes lie along the axes.
    """
    solid = Solid(
        box(kind, (20, 1, 1), (LENGTH, 0.05, 0.05)),
        StVenantKirchhoff(**STEEL),
        order=2,
        fixed=["x==0"],
    )
    modes, mass = linear_modes(solid, 4), solid.mass()
    for pair, root in enumerate(bending_roots(2, supports="clamped-free")):
        fields = np.array([bending_field(solid.points, axis, root).ravel() for axis in (1, 2)])
        fields /= np.sqrt(np.einsum("in,in->i", fields, (mass @ fields.T).T))[:, None]
        shapes = modes.shapes[2 * pair : 2 * pair + 2].reshape(2, -1)
        overlap = shapes @ mass @ fields.T
        assert np.linalg.svd(overlap, compute_uv=False).min() > 0.999
        if kind == "hexahedron":
            f = modes.frequencies[2 * pair : 2 * pair + 2]
            assert f[0] == pytest.approx(f[1], rel=1e-9)
            assert np.abs(overlap) == pytest.approx(np.eye(2), abs=1e-3)


def test_beam_of_steel_and_aluminium(tmp_path: Path) -> None:
    """Materials by the names of regions, against segments joined end to end."""
    mesh = drawn(two_material_beam, tmp_path, size=0.05, cell="hexahedron", height=HEIGHT)
    materials = {
        "aluminium": StVenantKirchhoff(**ALUMINIUM),
        "steel": StVenantKirchhoff(**STEEL),
    }
    modes = linear_modes(Solid(mesh, materials, order=2, fixed=["clamped"]), 8)
    segments = [
        Segment(length=0.5, section=SECTION, **constants) for constants in (STEEL, ALUMINIUM)
    ]
    for direction in "yz":
        theory = stepped_bending_frequencies(segments, count=2, direction=direction, shear=SHEAR)
        assert excess(modes, f"bending {direction}", theory) == pytest.approx(0.0, abs=0.015)
    torsion = stepped_torsional_frequencies(segments, count=1)
    assert excess(modes, "torsion", torsion)[0] == pytest.approx(0.0, abs=0.025)
    axial = stepped_axial_frequencies(segments, count=1)
    assert excess(modes, "axial", axial)[0] == pytest.approx(0.0, abs=0.008)
    swapped = {"steel": materials["aluminium"], "aluminium": materials["steel"]}
    other = linear_modes(Solid(mesh, swapped, order=2, fixed=["clamped"]), 1).frequencies[0]
    mirrored = stepped_bending_frequencies(segments[::-1], count=1, direction="z", shear=SHEAR)
    assert other == pytest.approx(mirrored[0], rel=0.015)
