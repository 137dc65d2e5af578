"""What meshes do to statics: orders, hexahedra against tetrahedra, volumetric locking."""

from functools import cache

import numpy as np
import pytest
from bodies import box, box_arrays, orders

from fenics_defo.analysis import Gravity, Pressure, static_equilibrium
from fenics_defo.energy import LinearElastic, NeoHookean
from fenics_defo.fem import Fixed, Solid, build_mesh

SPACES = [(kind, order) for kind in ("tetrahedron", "hexahedron") for order in (1, 2)]

SIZE = (2.0, 0.8, 0.8)
# A column that hangs from x = 0 along x: a quarter of it, between its planes of symmetry, so that
# no edge of it is singular. And a stub that is clamped at x = 0, whose clamped edges are.
CASES = {
    "column": ([Fixed("x==0", "x"), Fixed("y==0", "y"), Fixed("z==0", "z")], (1.0, 0.0, 0.0)),
    "stub": (["x==0"], (0.0, 0.0, -0.2)),
}


def loaded(case: str, kind: str, order: int, finer: int) -> tuple[Solid, Gravity]:
    """The body of 2 x 1 x 1 cells, made finer, and its weight."""
    fixed, weight = CASES[case]
    mesh = box(kind, (2 * finer, finer, finer), SIZE)
    material = NeoHookean(young=1.0e4, poisson=0.3, density=1000.0)
    return Solid(mesh, material, order=order, fixed=fixed), Gravity(weight)


@cache
def sag(case: str, kind: str, order: int, finer: int) -> float:
    """Mean displacement along the weight, by mass [m]."""
    solid, weight = loaded(case, kind, order, finer)
    found = static_equilibrium(solid, [weight], tolerance=1e-11, load_steps=2).displacement
    mean = (solid.mass() @ found.ravel()).reshape(-1, 3).sum(axis=0) / solid.total_mass()
    return float(mean @ weight.vector / np.linalg.norm(weight.vector))


@cache
def limit_of_sag(case: str) -> float:
    """From second-order hexahedra; extrapolated by their order 4 where nothing is singular."""
    middle, fine = (sag(case, "hexahedron", 2, finer) for finer in (2, 4))
    return fine + (fine - middle) / 15.0 if case == "column" else fine


def dofs_of_sag(case: str, kind: str, order: int, finer: int) -> int:
    """Number of displacement components of that mesh."""
    return loaded(case, kind, order, finer)[0].dof_count


@pytest.mark.parametrize(("kind", "order"), SPACES)
def test_error_falls_with_twice_the_order(kind: str, order: int) -> None:
    """The work of the weight errs with h^2p, whatever the cells, and all tend to one limit."""
    values = np.array([sag("column", kind, order, finer) for finer in (1, 2, 4)])
    assert values[2] > 0.05 * SIZE[0]
    errors = np.abs(values / limit_of_sag("column") - 1.0)
    assert errors[2] < (0.01 if order == 1 else 1e-5)
    # The limit is made of the two finest of second-order hexahedra.
    observed = orders(errors)[0 if (kind, order) == ("hexahedron", 2) else 1]
    assert observed == pytest.approx(2.0 * order, abs={1: 0.3, 2: 1.1}[order])


def test_hexahedra_against_tetrahedra_in_bending() -> None:
    """Order 1 is too stiff in bending, tetrahedra by far; order 2 on coarser cells is not."""
    limit = limit_of_sag("stub")
    assert limit > 0.05 * SIZE[0]

    def stiffer(kind: str, order: int, finer: int) -> float:
        return 1.0 - sag("stub", kind, order, finer) / limit

    tetrahedra, hexahedra = (
        np.array([stiffer(kind, 1, finer) for finer in (1, 2, 4)])
        for kind in ("tetrahedron", "hexahedron")
    )
    assert (np.diff(tetrahedra) < 0.0).all()
    assert (np.diff(hexahedra) < 0.0).all()
    assert (tetrahedra > 1.5 * hexahedra).all()
    assert tetrahedra[0] > 0.4
    assert hexahedra[2] < 0.07
    for kind in ("tetrahedron", "hexahedron"):
        assert 0.0 < stiffer(kind, 2, 2) < hexahedra[2]


# MacNeal and Harder, A proposed standard set of problems to test finite element accuracy, Finite
# Elements in Analysis and Design 1 (1985) 3: the thick-walled cylinder in plane strain.
INNER, OUTER, YOUNG, PRESSURE = 3.0, 9.0, 1000.0, 1.0
RADII = np.array([3.0, 3.5, 4.2, 5.2, 6.75, 9.0])
PUBLISHED = {0.49: 5.0399e-3, 0.499: 5.0602e-3, 0.4999: 5.0623e-3}


def lame(poisson: float) -> float:
    """Radial displacement at the inner wall [m] under the pressure 1, by Lamé."""
    factor = (1.0 + poisson) * PRESSURE * INNER / (YOUNG * (OUTER**2 - INNER**2))
    return factor * ((1.0 - 2.0 * poisson) * INNER**2 + OUTER**2)


@cache
def widening(kind: str, order: int, poisson: float, finer: int = 1) -> float:
    """Computed over exact radial displacement of the inner wall of a quarter of the cylinder."""
    points, rows = box_arrays(kind, (5 * finer, 18 * finer, 1), (5.0, 0.5 * np.pi, 0.5))
    radius = np.interp(points[:, 0], np.arange(6), RADII)
    angle = points[:, 1].copy()
    points[:, 0], points[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
    points[np.abs(points) < 1e-12] = 0.0
    material = LinearElastic(young=YOUNG, poisson=poisson, density=1.0)
    fixed = [Fixed("x==0", "x"), Fixed("y==0", "y"), Fixed("x>=0", "z")]
    solid = Solid(build_mesh(points, rows, kind=kind), material, order=order, fixed=fixed)
    # The pressure follows the wall: so small a one does not notice.
    small = 1e-6
    load = Pressure("x*x+y*y<9.01", value=small * PRESSURE)
    found = static_equilibrium(solid, [load]).displacement / small
    inner = np.abs(np.hypot(solid.points[:, 0], solid.points[:, 1]) - INNER) < 1e-9
    radial = np.einsum("ij,ij->i", found[inner, :2], solid.points[inner, :2]) / INNER
    return float(radial.mean() / lame(poisson))


def test_lame_is_the_published_theory() -> None:
    for poisson, displacement in PUBLISHED.items():
        assert lame(poisson) == pytest.approx(displacement, abs=0.6e-7)


KINDS = ("tetrahedron", "hexahedron")


@pytest.mark.parametrize("kind", KINDS)
def test_first_order_locks_where_volume_is_kept(kind: str) -> None:
    """The nearer to 1/2, the less an order-1 mesh moves at all, and refinement hardly helps."""
    found = [widening(kind, 1, poisson) for poisson in (0.3, 0.49, 0.4999)]
    assert found[0] > 0.96
    assert found[1] < 0.86
    assert found[2] < 0.33
    assert widening(kind, 1, 0.4999, 2) < 0.4


@pytest.mark.parametrize("kind", KINDS)
def test_second_order_hardly_locks(kind: str) -> None:
    """To half a per cent up to 0.49, 1.5 % at 0.499; at 0.4999 hexahedra need a finer mesh."""
    worst = {"tetrahedron": 0.025, "hexahedron": 0.13}[kind]
    for poisson, bound in ((0.49, 0.005), (0.499, 0.015), (0.4999, worst)):
        assert widening(kind, 2, poisson) == pytest.approx(1.0, abs=bound)
