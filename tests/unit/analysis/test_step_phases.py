"""Where the time of a step goes, as the stopwatch of a simulation tells."""

import time

import numpy as np
import pytest

from fenics_defo import analysis, energy, fem

CORNERS = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])


@pytest.mark.parametrize("linear", ["cholesky", "pcg-jacobi"])
def test_phases_of_a_step(linear: str) -> None:
    rubber = energy.StVenantKirchhoff(young=1e6, poisson=0.3, density=1000.0)
    solid = fem.Solid(fem.build_mesh(CORNERS, np.array([[0, 1, 2, 3]])), rubber, fixed=["z<0.1"])
    phases = analysis.Phases()
    with analysis.Simulation(
        solid,
        [analysis.Gravity()],
        analysis.ImplicitNewmark(),
        step=0.01,
        linear=linear,
        phases=phases,
    ) as simulation:
        phases.seconds.clear()
        begin = time.perf_counter()
        simulation.advance()
        passed = time.perf_counter() - begin
    assert set(phases.seconds) == {"tangent", "residual", "factorise", "solve"}
    assert all(seconds > 0.0 for seconds in phases.seconds.values())
    assert sum(phases.seconds.values()) <= passed


def test_explicit_steps_have_a_residual_only() -> None:
    rubber = energy.StVenantKirchhoff(young=1e6, poisson=0.3, density=1000.0)
    solid = fem.Solid(fem.build_mesh(CORNERS, np.array([[0, 1, 2, 3]])), rubber, fixed=["z<0.1"])
    phases = analysis.Phases()
    with analysis.Simulation(
        solid, [], analysis.CentralDifferences(), step=1e-4, phases=phases
    ) as simulation:
        simulation.advance()
    assert set(phases.seconds) == {"residual"}
