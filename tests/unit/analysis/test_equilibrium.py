"""Static equilibria against linear solves, beams, energies and reactions."""

import numpy as np
import pytest
from modal_bodies import box
from moving_bodies import LINEAR, NEO, STVK, TIP, bar, cube
from scipy.sparse.linalg import spsolve

from fenics_defo import beams
from fenics_defo.analysis import (
    Gravity,
    Impulse,
    PointLoad,
    Prescribed,
    Pressure,
    Sine,
    Traction,
    static_equilibrium,
)
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.errors import DivergenceError, LoadError, SolverError

# What keeps a free cube from moving rigidly.
PINS = [
    Prescribed("x==0 and y==0 and z==0", (0, 0, 0)),
    Prescribed("x==1 and y==0 and z==0", (None, 0, 0)),
    Prescribed("x==0 and y==1 and z==0", (None, None, 0)),
]


def solved(solid, force):
    """K⁻¹ times nodal forces (n, 3) by SciPy."""
    free = np.flatnonzero(~solid.held.ravel())
    u = np.zeros(solid.held.size)
    stiffness = solid.tangent().tocsc()[free][:, free]
    u[free] = spsolve(stiffness, force.ravel()[free])
    return u.reshape(-1, 3)


def nodal_forces(solid, kind):
    """A load and its nodal forces by another way."""
    mass = solid.mass()
    if kind == "gravity":
        vector = np.array([0.3, 0.2, -1.0])
        return Gravity(vector), (mass @ np.tile(vector, len(solid.points))).reshape(-1, 3)
    if kind == "point":
        force = np.zeros_like(solid.points)
        force[np.all(np.isclose(solid.points, TIP), axis=1)] = (1.0, 2.0, 3.0)
        return PointLoad(point=TIP, vector=(1.0, 2.0, 3.0)), force
    # Bilinear functions on a 2 x 1 grid of equal faces: a quarter of each to each corner.
    force = np.zeros_like(solid.points)
    for i, (x, y, _) in enumerate(solid.points):
        if x == 1.0:
            force[i, 2] = 70.0 * 0.06 / 8.0 * (2.0 if np.isclose(y, 0.15) else 1.0)
    return Traction("x==1", (0.0, 0.0, 70.0)), force


@pytest.mark.parametrize("kind", ["gravity", "point", "traction"])
@pytest.mark.parametrize("linear", ["cholesky", "pcg-jacobi", "pcg-amg"])
def test_a_linear_body_rests_where_its_stiffness_says(kind, linear):
    solid = bar(LINEAR)
    load, force = nodal_forces(solid, kind)
    found = static_equilibrium(solid, [load], linear=linear)
    expected = solved(solid, force)
    assert found.displacement == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    assert found.strain_energy == pytest.approx(0.5 * np.vdot(force, expected), rel=1e-7)
    assert found.reactions.sum(axis=0) == pytest.approx(-force.sum(axis=0), rel=1e-6, abs=1e-7)
    assert not found.reactions[~solid.held].any()
    assert found.residuals[-1][-1] <= 1e-8
    assert found.load_factors == (1.0,)


def test_the_elastica_bends_as_the_beam_does():
    """A slender cantilever under ten times the load that is small."""
    section = beams.RectangularSection(width=0.02, height=0.02)
    young = 1.0e6
    material = StVenantKirchhoff(young=young, poisson=0.0, density=1.0)
    size = (1.0, 0.02, 0.02)
    solid = box((16, 1, 1), size, kind="hexahedron", order=2, material=material, fixed=["x==0"])
    force = 10.0 * young * 0.02**4 / 12.0
    found = static_equilibrium(solid, [Traction("x==1", (0.0, 0.0, force / 0.02**2))])
    tip = solid.points + found.displacement
    tip = tip[np.isclose(solid.points[:, 0], 1.0)].mean(axis=0)
    pose = beams.elastica_end_force(length=1.0, section=section, young=young, force=force)
    assert tip[0] == pytest.approx(pose.x, rel=0.01)
    assert tip[2] - 0.01 == pytest.approx(pose.y, rel=0.01)
    assert found.definite


def test_prescribed_displacement_does_the_work_that_is_stored():
    """Linear: half of reaction times displacement. Nonlinear: the integral over small parts."""
    pull = [Prescribed("x==1", (0.1, None, 0.05), history=Sine(1.0))]  # histories do not count
    solid = bar(LINEAR)
    found = static_equilibrium(solid, [], prescribed=pull)
    end = solid.points[:, 0] == 1.0
    assert found.displacement[end][:, [0, 2]] == pytest.approx(np.full((6, 2), (0.1, 0.05)))
    assert np.ptp(found.displacement[end][:, 1]) > 1e-4
    work = 0.5 * np.vdot(found.reactions[end], found.displacement[end])
    assert found.strain_energy == pytest.approx(work, rel=1e-8)
    assert found.reactions.sum(axis=0) == pytest.approx(
        0.0, abs=1e-7 * np.abs(found.reactions).max()
    )


def test_a_large_compression_needs_the_search():
    """Squeezed to a tenth in one part: cells must not turn inside out on the way."""
    solid = cube(NEO)
    squeeze = [Prescribed("z==1", (0.0, 0.0, -0.9))]
    found = static_equilibrium(solid, [], prescribed=squeeze)
    parts = static_equilibrium(solid, [], prescribed=squeeze, load_steps=10)
    assert len(parts.load_factors) == 10
    assert found.strain_energy == pytest.approx(parts.strain_energy, rel=1e-9)
    assert found.displacement == pytest.approx(parts.displacement, abs=1e-7)


def test_pressure_on_all_sides_compresses_evenly():
    """Neo-Hookean: σ = (μ (s² - 1) + 3 λ ln s) / s³ = -p at the stretch s."""
    faces = [Pressure(f"{c}=={side}", 3.0e4) for c in "xyz" for side in (0, 1)]
    solid = cube(NEO, held=None)
    found = static_equilibrium(solid, faces, prescribed=PINS, tolerance=1e-10)
    stretch = 1.0 + found.displacement[np.argmax(solid.points.sum(axis=1))].mean()
    mu, lmbda = 1.0e5 / 2.6, 1.0e5 * 0.3 / (1.3 * 0.4)
    stress = (mu * (stretch**2 - 1.0) + 3.0 * lmbda * np.log(stretch)) / stretch**3
    assert stress == pytest.approx(-3.0e4, rel=1e-7)
    assert found.displacement == pytest.approx((stretch - 1.0) * solid.points, abs=1e-8)
    # A closed surface under pressure pushes nowhere.
    assert found.reactions == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_newton_keeps_its_order_under_pressure(sign):
    """The pressure's tangent is complete: the last residuals fall quadratically."""
    found = static_equilibrium(cube(NEO), [Pressure("z==1", sign * 2.0e4)], tolerance=1e-11)
    assert found.iterations <= 7


def test_loads_beyond_what_the_body_bears_are_told():
    """Blown up, the neo-Hookean stress (μ (s² - 1) + 3 λ ln s) / s³ has a maximum of 35 kPa."""
    faces = [Pressure(f"{c}=={side}", -5.0e4) for c in "xyz" for side in (0, 1)]
    with pytest.raises(DivergenceError, match="no equilibrium was found beyond") as info:
        static_equilibrium(
            cube(NEO, held=None), faces, prescribed=PINS, max_halvings=4, max_iterations=12
        )
    assert 0.6 <= info.value.time < 0.71
    assert "collapse" in str(info.value)


def test_cells_that_turned_inside_out_are_told(caplog):
    """St. Venant-Kirchhoff falls through its limit point in compression, at the stretch 1/√3."""
    push = Traction("z==1", (0.0, 0.0, -1.0e5))
    found = static_equilibrium(cube(STVK), [push])
    assert found.inverted_cells == 8
    assert "inside out" in caplog.text
    assert static_equilibrium(cube(STVK), []).inverted_cells == 0


def test_what_has_no_equilibrium_is_refused():
    with pytest.raises(SolverError, match="6 rigid motions"):
        static_equilibrium(bar(LINEAR, held=None), [Gravity()])
    with pytest.raises(LoadError, match="impulse"):
        static_equilibrium(bar(LINEAR), [Impulse(region="x==1", vector=(1, 0, 0))])
    with pytest.raises(LoadError, match="load_steps"):
        static_equilibrium(bar(LINEAR), [], load_steps=0)


def test_nothing_rests_as_it_is():
    found = static_equilibrium(bar(STVK), [])
    assert not found.displacement.any()
    assert found.strain_energy == 0.0


def test_an_equilibrium_can_be_the_start_of_the_next():
    loads = [Gravity((0.0, 0.0, -2.0))]
    first = static_equilibrium(bar(STVK), loads)
    again = static_equilibrium(bar(STVK), loads, initial=first.displacement)
    assert again.iterations <= 1
    assert again.displacement == pytest.approx(first.displacement, abs=1e-9)
