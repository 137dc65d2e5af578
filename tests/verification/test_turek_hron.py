"""A St. Venant-Kirchhoff bar under gravity against Turek and Hron's published results.

Turek and Hron, Proposal for numerical benchmarking of fluid-structure interaction between an
elastic object and laminar incompressible flow (2006), tests CSM1 to CSM3: a bar of 0.35 m x 0.02 m
in plane strain, clamped on a circle of the radius 0.05 m; A is the middle of its free end. Their
figures for the finest grids (TU Dortmund's page of the benchmark) are in millimetres.
"""

import numpy as np
import pytest
from bodies import Array, box_arrays

from fenics_defo.analysis import Gravity, ImplicitNewmark, simulate, static_equilibrium
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Fixed, Solid, build_mesh

GRAVITY = Gravity((0.0, -2.0, 0.0))
MIDDLE = (0.6, 0.01, 0.005)
CSM1, CSM2 = (-7.18777, -66.1029), (-0.469006, -16.9740)
# Mean and amplitude, those of the extreme values.
CSM3_X, CSM3_Y, CSM3_HERTZ = (-14.305, 14.305), (-63.607, 65.160), 1.0995


def bar(cells: int, layers: int, *, young: float = 1.4e6) -> Solid:
    """The bar in the coordinates of the circle's middle; one cell across, which keeps its width."""
    points, rows = box_arrays("hexahedron", (cells, layers, 1), (1.0, 0.02, 0.01))
    start = 0.2 + np.sqrt(0.05**2 - (points[:, 1] - 0.01) ** 2)
    points[:, 0] = start + (0.6 - start) * points[:, 0]
    material = StVenantKirchhoff(young=young, poisson=0.4, density=1000.0)
    fixed = ["x<0.2501", Fixed("x>0", "z")]
    return Solid(build_mesh(points, rows, kind="hexahedron"), material, order=2, fixed=fixed)


def at_rest(cells: int, layers: int, young: float) -> Array:
    """Displacement of A [mm] at rest."""
    solid = bar(cells, layers, young=young)
    found = static_equilibrium(solid, [GRAVITY], load_steps=2).displacement
    return 1e3 * found[np.linalg.norm(solid.points - MIDDLE, axis=1).argmin()]


@pytest.mark.parametrize(("young", "published"), [(1.4e6, CSM1), (5.6e6, CSM2)])
def test_static_deflection(young: float, published: tuple[float, float]) -> None:
    """The clamp's corners are singular: the error halves about with the size of the cells."""
    errors = [
        at_rest(cells, layers, young)[:2] / published - 1.0 for cells, layers in ((17, 1), (34, 2))
    ]
    assert np.abs(errors[1]).max() < 0.006
    assert (np.abs(errors[1]) < 0.7 * np.abs(errors[0])).all()


def swing(*, cells: int, layers: int, step: float, duration: float) -> tuple[Array, Array, Array]:
    """Times [s], ux and uy [mm] of A after the release from the straight shape."""
    motion = simulate(
        bar(cells, layers),
        [GRAVITY],
        ImplicitNewmark(),
        step=step,
        duration=duration,
        newton=None,
        probes={"A": MIDDLE},
        energies_every=0,
    )
    x, y, _ = 1e3 * motion.probes["A"].T
    return motion.times, x, y


def frequency(times: Array, y: Array) -> float:
    """From the crossings of the mean on the way down [Hz]."""
    high = y > 0.5 * (y.min() + y.max())
    down = np.flatnonzero(high[:-1] & ~high[1:])
    level = y - 0.5 * (y.min() + y.max())
    at = times[down] + level[down] / (level[down] - level[down + 1]) * np.diff(times)[down]
    return float(1.0 / (at[1] - at[0]))


def test_swinging_bar() -> None:
    """CSM3 on a coarse mesh with large steps."""
    times, x, y = swing(cells=12, layers=1, step=0.02, duration=1.9)
    for values, (mean, amplitude) in ((x, CSM3_X), (y, CSM3_Y)):
        assert 0.5 * (values.min() + values.max()) == pytest.approx(mean, rel=0.03)
        assert 0.5 * np.ptp(values) == pytest.approx(amplitude, rel=0.03)
    assert frequency(times, y) == pytest.approx(CSM3_HERTZ, rel=0.01)
