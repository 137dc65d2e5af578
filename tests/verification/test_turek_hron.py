"""A St. Venant-Kirchhoff bar under gravity against Turek and Hron's published results.

Turek and Hron, Proposal for numerical benchmarking of fluid-structure interaction between an
elastic object and laminar incompressible flow (2006), tests CSM1 to CSM3: a bar of 0.35 m x 0.02 m
in plane strain, clamped on a circle of the radius 0.05 m; A is the middle of its free end. Their
figures for the finest grids (TU Dortmund's page of the benchmark) are in millimetres.
"""

import numpy as np
import pytest
from bodies import box_arrays

from fenics_defo.analysis import Gravity, ImplicitNewmark, simulate, static_equilibrium
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Fixed, Solid, build_mesh

GRAVITY = Gravity((0.0, -2.0, 0.0))
MIDDLE = (0.6, 0.01, 0.005)
CSM1, CSM2 = (-7.18777, -66.1029), (-0.469006, -16.9740)


def bar(cells: int, layers: int, *, young: float = 1.4e6) -> Solid:
    """The bar in the coordinates of the circle's middle; one cell across, which keeps its width."""
    points, rows = box_arrays("hexahedron", (cells, layers, 1), (1.0, 0.02, 0.01))
    start = 0.2 + np.sqrt(0.05**2 - (points[:, 1] - 0.01) ** 2)
    points[:, 0] = start + (0.6 - start) * points[:, 0]
    material = StVenantKirchhoff(young=young, poisson=0.4, density=1000.0)
    fixed = ["x<0.2501", Fixed("x>0", "z")]
    return Solid(build_mesh(points, rows, kind="hexahedron"), material, order=2, fixed=fixed)


def at_rest(cells: int, layers: int, young: float) -> np.ndarray:
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


def test_swinging_bar() -> None:
    """CSM3, released from its straight shape: ux = -14.305 ± 14.305, uy = -63.607 ± 65.160 mm at
    1.0995 Hz, where mean and amplitude are those of the extreme values."""
    motion = simulate(
        bar(17, 1),
        [GRAVITY],
        ImplicitNewmark(),
        step=0.01,
        duration=1.86,
        newton=None,
        probes={"A": MIDDLE},
        energies_every=0,
    )
    x, y, _ = 1e3 * motion.probes["A"].T
    assert 0.5 * (y.min() + y.max()) == pytest.approx(-63.607, rel=0.02)
    assert 0.5 * (y.max() - y.min()) == pytest.approx(65.160, rel=0.02)
    assert 0.5 * (x.min() + x.max()) == pytest.approx(-14.305, rel=0.02)
    assert 0.5 * (x.max() - x.min()) == pytest.approx(14.305, rel=0.02)
    low = [
        motion.times[part][y[part].argmin()] for part in (motion.times < 0.9, motion.times > 0.9)
    ]
    assert 1.0 / (low[1] - low[0]) == pytest.approx(1.0995, rel=0.02)
