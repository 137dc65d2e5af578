"""The cubic law of St. Venant-Kirchhoff is the finite elements' own force, whatever they are."""

import tracemalloc
from collections.abc import Mapping

import numpy as np
import pytest
import ufl
from ufl.core.expr import Expr

from fenics_defo.energy import (
    Corotational,
    HyperelasticEnergy,
    Invertible,
    LinearElastic,
    MassSpring,
    NeoHookean,
    StVenantKirchhoff,
    green_lagrange,
)
from fenics_defo.errors import DefoError, MaterialError
from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection
from fenics_defo.reduction import DirectForce, tabulate_cubic, tabulate_linear
from fenics_defo.reduction.gram_tabulation import strain_derivatives
from tests.unit.fem.fem_bodies import MODULI, mesh_of, source
from tests.unit.reduction.tabulated_bodies import (
    ELEMENTS,
    SOFT,
    bent_body,
    coordinates,
    relative,
    smooth_shapes,
)

# Of the body's size: from where strains are all but linear to where nothing of the rest is left.
AMPLITUDES = (1e-6, 1e-3, 0.1, 0.5)


def agree(solid: Solid, size: int = 7, tolerance: float = 1e-12) -> None:
    """Force, stiffness and energy of the cubic law against the assembled ones."""
    shapes = smooth_shapes(solid, size)
    law, direct = tabulate_cubic(solid, shapes), DirectForce(solid, shapes)
    for amplitude in AMPLITUDES:
        q = coordinates(shapes, amplitude)
        assert relative(law.force(q), direct.force(q)) < tolerance
        assert relative(law.stiffness(q), direct.stiffness(q)) < tolerance
        assert relative(law.energy(q), direct.energy(q)) < tolerance


@pytest.mark.parametrize("element", ELEMENTS)
def test_it_is_the_assembled_force(element: tuple[str, int, int]) -> None:
    agree(bent_body(element=element))


def test_regions_may_be_linear() -> None:
    linear = LinearElastic(young=3.0e5, poisson=0.2, density=1.0e3)
    agree(bent_body({None: SOFT, "x>0.7": linear}))
    agree(bent_body(linear))


def test_a_field_of_moduli_and_a_negative_poisson_ratio() -> None:
    cells = 6 * 4 * 2
    field = StVenantKirchhoff(
        young=np.geomspace(1e4, 1e7, cells), poisson=np.linspace(-0.8, 0.45, cells), density=1e3
    )
    agree(bent_body(field))


def test_it_is_the_formula_that_counts() -> None:
    """An energy of the user's own passes if it is the same function, and only then."""

    def energy(F: Expr, c: Mapping[str, Expr]) -> Expr:
        E = green_lagrange(F)
        return c["lmbda"] / 2 * ufl.tr(E) ** 2 + c["mu"] * ufl.inner(E, E)

    def along_x(F: Expr, c: Mapping[str, Expr]) -> Expr:
        return energy(F, c) + c["mu"] * green_lagrange(F)[0, 0] ** 2

    lame = {"mu": 1e5, "lmbda": 2e5}
    agree(bent_body(HyperelasticEnergy(energy, lame, density=1e3)))
    other = bent_body(HyperelasticEnergy(along_x, lame, density=1e3))
    with pytest.raises(MaterialError, match="HyperelasticEnergy"):
        tabulate_cubic(other, smooth_shapes(other, 1))
    unstable = bent_body(HyperelasticEnergy(energy, {"mu": 1e5, "lmbda": -1e5}, density=1e3))
    with pytest.raises(MaterialError, match="needs mu > 0 and a bulk modulus"):
        tabulate_cubic(unstable, smooth_shapes(unstable, 1))


def test_a_free_body_turns_at_no_cost() -> None:
    """Rotations that the shapes can express strain nothing, however large."""
    solid = bent_body(fixed=[])
    x, y, _ = solid.points.T
    zero = np.zeros_like(x)
    stretch = np.column_stack([x, y, zero])
    turn = np.column_stack([-y, x, zero])
    law = tabulate_cubic(solid, np.array([stretch, turn]))
    stiffness = np.linalg.norm(law.stiffness(np.zeros(2)))
    for angle in (0.1, 1.0, 3.0):
        q = np.array([np.cos(angle) - 1.0, np.sin(angle)])
        assert np.abs(law.force(q)).max() < 1e-13 * stiffness
        assert abs(law.energy(q)) < 1e-13 * stiffness
        velocity = np.array([-np.sin(angle), np.cos(angle)])
        assert np.abs(law.stiffness(q) @ velocity).max() < 1e-13 * stiffness


def test_force_and_stiffness_are_derivatives() -> None:
    """Differences of five points are exact for polynomials of the fourth degree."""
    solid = bent_body(element=("hexahedron", 1, 1))
    shapes = smooth_shapes(solid, 5)
    law = tabulate_cubic(solid, shapes)
    q, along = coordinates(shapes, 0.3)
    points = q + np.outer((-2.0, -1.0, 1.0, 2.0), along)
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
    assert weights @ law.energy(points) == pytest.approx(law.force(q) @ along, rel=1e-11)
    assert relative([weights @ law.force(points)], np.array([law.stiffness(q) @ along])) < 1e-12
    np.testing.assert_array_equal(law.stiffness(q), law.stiffness(q).T)


@pytest.mark.parametrize("element", ELEMENTS[:2])
def test_linear_law_is_the_tangent_at_rest(element: tuple[str, int, int]) -> None:
    solid = bent_body(element=element)
    shapes = smooth_shapes(solid, 4)
    zero = np.zeros(4)
    wanted = DirectForce(solid, shapes).stiffness(zero)
    assert relative([tabulate_linear(solid, shapes).stiffness(zero)], wanted[None]) < 1e-13
    assert relative([tabulate_cubic(solid, shapes).stiffness(zero)], wanted[None]) < 1e-13


def test_columns_change_nothing_of_each_other() -> None:
    """The law of some shapes is part of the law of more: blocks of points differ."""
    solid = bent_body()
    shapes = smooth_shapes(solid, 40)
    q = np.append(coordinates(shapes[:3], 0.2)[0], np.zeros(37))
    few, many = tabulate_cubic(solid, shapes[:3]), tabulate_cubic(solid, shapes)
    np.testing.assert_allclose(many.force(q)[:3], few.force(q[:3]), rtol=1e-12)


def test_memory_does_not_grow_with_the_mesh() -> None:
    def peak(cells: tuple[int, int, int]) -> int:
        solid = Solid(mesh_of(source("tetrahedron", cells=cells)), SOFT)
        fields = Projection(solid, smooth_shapes(solid, 8)).fields
        strain_derivatives(solid, fields[:1])  # what is made once, and kept
        tracemalloc.start()
        try:
            strain_derivatives(solid, fields)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    small, large = peak((16, 8, 8)), peak((32, 16, 8))
    cells = 6 * 32 * 16 * 8 - 6 * 16 * 8 * 8
    # Numbers of cells and their moduli at most; the columns of one cell take two thousand bytes.
    assert large - small < 40 * cells


@pytest.mark.parametrize(
    "law",
    [
        NeoHookean(**MODULI),
        Corotational(**MODULI),
        Invertible(StVenantKirchhoff(**MODULI)),
        MassSpring(young=1e5, density=1e3),
    ],
)
def test_other_laws_are_refused(law: object) -> None:
    solid = bent_body({None: SOFT, "x>0.7": law})
    with pytest.raises(MaterialError, match=type(law).__name__) as refused:
        tabulate_cubic(solid, smooth_shapes(solid, 2))
    assert 'force = "taylor"' in str(refused.value)
    assert '"cubature"' in str(refused.value)


@pytest.mark.parametrize("shape", [(2, 30, 2), (30, 3), (0, 30, 3), (2, 29, 3)])
def test_shapes_of_another_body_are_refused(shape: tuple[int, ...]) -> None:
    solid = bent_body(SOFT)
    assert solid.nodes.size == 30
    with pytest.raises(DefoError, match="shapes of a reduced body must be"):
        tabulate_cubic(solid, np.zeros(shape))


def test_shapes_must_be_finite() -> None:
    solid = bent_body(SOFT)
    shapes = smooth_shapes(solid, 2)
    shapes[1, 3, 2] = np.nan
    with pytest.raises(DefoError, match="must be finite"):
        tabulate_cubic(solid, shapes)


def test_the_direct_law_takes_batches_and_is_not_stored() -> None:
    solid = bent_body(NeoHookean(**MODULI))
    shapes = smooth_shapes(solid, 3)
    law = DirectForce(solid, shapes)
    q = coordinates(shapes, 0.05, 4).reshape(2, 2, 3)
    np.testing.assert_array_equal(law.force(q)[1, 0], law.force(q[1, 0]))
    np.testing.assert_array_equal(law.stiffness(q)[0, 1], law.stiffness(q[0, 1]))
    assert law.energy(q).shape == (2, 2)
    for shape in ((3,), (4, 3)):
        at = q.reshape(4, 3)[0] if len(shape) == 1 else q.reshape(4, 3)
        force, stiffness = law.evaluator(shape).force_and_stiffness(at)
        np.testing.assert_array_equal(force, law.force(at))
        np.testing.assert_array_equal(stiffness, law.stiffness(at))
        np.testing.assert_array_equal(law.evaluator(shape).force(at), law.force(at))
    h = 1e-6
    slope = (law.force(q[0, 0] + h * q[0, 1]) - law.force(q[0, 0] - h * q[0, 1])) / (2.0 * h)
    assert relative([slope], (law.stiffness(q[0, 0]) @ q[0, 1])[None]) < 1e-8
    with pytest.raises(DefoError, match="cannot be stored"):
        law.arrays()
    with pytest.raises(ValueError, match="must have the shape"):
        law.force(np.zeros(4))
