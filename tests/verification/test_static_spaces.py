"""What meshes do to statics: patch tests, hexahedra against tetrahedra, volumetric locking."""

from functools import cache

import numpy as np
import pytest
from bodies import box, box_arrays, orders, richardson_order

from fenics_defo.analysis import Gravity, Pressure, static_equilibrium
from fenics_defo.energy import LinearElastic, StVenantKirchhoff
from fenics_defo.fem import Fixed, Solid, build_mesh

SPACES = [(kind, order) for kind in ("tetrahedron", "hexahedron") for order in (1, 2)]

# Half of a bar that hangs between walls which hold its ends' height: mirrored about x = 0, so that
# no edge of it is singular.
SPAN, HEIGHT = 2.0, 0.8
HELD = [Fixed("x==0", "x"), Fixed(f"x=={SPAN}", "yz")]


def hanging(kind: str, order: int, finer: int) -> Solid:
    """The half bar of 2 x 1 x 1 cells, made finer."""
    mesh = box(kind, (2 * finer, finer, finer), (SPAN, HEIGHT, HEIGHT))
    material = StVenantKirchhoff(young=1.0e4, poisson=0.3, density=1000.0)
    return Solid(mesh, material, order=order, fixed=HELD)


@cache
def sag(kind: str, order: int, finer: int) -> float:
    """Mean deflection under gravity, by mass: a large one, an eighth of the span."""
    solid = hanging(kind, order, finer)
    weight = Gravity((0.0, 0.0, -0.4))
    found = static_equilibrium(solid, [weight], tolerance=1e-11).displacement
    mean = (solid.mass() @ found.ravel()).reshape(-1, 3).sum(axis=0) / solid.total_mass()
    return float(-mean[2])


def limit_of_sag() -> float:
    """Extrapolated by the order 4 of second-order hexahedra."""
    middle, fine = (sag("hexahedron", 2, finer) for finer in (2, 4))
    return fine + (fine - middle) / 15.0


def dofs_of_sag(kind: str, order: int, finer: int) -> int:
    """Number of displacement components of that mesh."""
    return hanging(kind, order, finer).dof_count


def test_second_order_converges_with_order_four() -> None:
    values = [sag("hexahedron", 2, finer) for finer in (1, 2, 4)]
    assert values[2] > SPAN / 10.0
    assert richardson_order(values) == pytest.approx(4.0, abs=0.8)


@pytest.mark.parametrize(("kind", "order"), SPACES[:3])
def test_tetrahedra_and_hexahedra_share_their_limit(kind: str, order: int) -> None:
    """Compliance errs with h^2p, from below: the discrete body is too stiff."""
    limit = limit_of_sag()
    errors = np.array([1.0 - sag(kind, order, finer) / limit for finer in (2, 4)])
    assert (errors > 0.0).all()
    assert orders(errors)[0] == pytest.approx(2.0 * order, abs=0.5 * order)


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
    found = [widening(kind, 1, poisson) for poisson in (0.3, 0.49, 0.499, 0.4999)]
    assert found[0] > 0.96
    assert found[1] < 0.86
    assert found[2] < 0.42
    assert found[3] < 0.33
    assert widening(kind, 1, 0.4999, 2) < 0.4


@pytest.mark.parametrize("kind", KINDS)
def test_second_order_hardly_locks(kind: str) -> None:
    """To half a per cent up to 0.49, 1.5 % at 0.499; at 0.4999 a finer mesh is within 1 %."""
    for poisson, bound in ((0.3, 0.003), (0.49, 0.005), (0.499, 0.015)):
        assert widening(kind, 2, poisson) == pytest.approx(1.0, abs=bound)
    coarse, fine = (1.0 - widening(kind, 2, 0.4999, finer) for finer in (1, 2))
    assert fine < min(0.01, 0.3 * coarse)
