"""Steps and equilibria that Newton's method alone does not find, and what is said where none is."""

import logging

import numpy as np
import pytest
from modal_bodies import box
from moving_bodies import NEO, SOFT, STVK, bar, cube

from fenics_defo import fem
from fenics_defo.analysis import (
    BackwardEuler,
    Gravity,
    ImplicitNewmark,
    Initial,
    Prescribed,
    Simulation,
    Step,
    Traction,
    simulate,
    static_equilibrium,
)
from fenics_defo.energy import Corotational, Invertible, IsotropicEnergy, NeoHookean
from fenics_defo.energy.materials import ufl
from fenics_defo.errors import DivergenceError, LoadError

MU, LMBDA = 1.0e5 / 2.6, 1.0e5 * 0.3 / (1.3 * 0.4)
PERIOD = np.sqrt(1000.0 / 1.0e5)


def _ciarlet(I1, _, J, constants):
    """Its stress is finite where det F < 0, and ln J is no number there."""
    mu, lmbda, ln = constants["mu"], constants["lmbda"], ufl.ln(J)
    return mu / 2 * (I1 - 3 - 2 * ln) + lmbda / 4 * (J**2 - 1 - 2 * ln)


OWN = IsotropicEnergy(_ciarlet, {"mu": MU, "lmbda": LMBDA}, density=1000.0)


def mirrored(solid):
    return Initial(displacement=solid.points * (0.0, 0.0, -2.0))


def test_an_energy_that_is_no_number_is_no_equilibrium():
    """Crushed to half of its height, mirrored: the law has no such state."""
    solid = cube(OWN)
    with pytest.raises(DivergenceError, match="finite forces and energy"):
        static_equilibrium(
            solid,
            [],
            prescribed=[Prescribed("z==1", (0.0, 0.0, -1.5))],
            max_halvings=1,
            max_iterations=10,
        )


@pytest.mark.parametrize("newton", [1, None])
def test_an_energy_that_is_no_number_is_no_start(newton):
    solid = cube(OWN)
    assert np.isfinite(solid.internal_force(mirrored(solid).displacement)).all()
    with pytest.raises(LoadError, match="energy is infinite or no number"):
        Simulation(solid, [], BackwardEuler(), step=PERIOD, newton=newton, initial=mirrored(solid))


@pytest.mark.parametrize("newton", [1, None])
def test_an_energy_that_is_no_number_is_no_step(newton):
    """A cube whose top falls through its foot in one step."""
    solid = cube(OWN)
    crush = Prescribed("z==1", (0.0, 0.0, -1.5), lambda t: 1.0 if t > 0.0 else 0.0)
    with (
        Simulation(
            solid,
            [],
            ImplicitNewmark(),
            step=PERIOD,
            newton=newton,
            prescribed=[crush],
            max_halvings=1,
        ) as simulation,
        pytest.raises(DivergenceError, match="energy"),
    ):
        simulation.advance()


INVERTIBLE = {
    "corotational": Corotational(**SOFT),
    "warped": Corotational(**SOFT, tangent="approximate"),
    "invertible": Invertible(NeoHookean(**SOFT)),
}


@pytest.mark.parametrize("law", INVERTIBLE)
def test_a_body_that_is_inside_out_finds_back(law):
    """Its mirror image lies on the ridge of the energy, where the rotation is anybody's guess."""
    solid = cube(INVERTIBLE[law])
    motion = simulate(
        solid,
        [],
        BackwardEuler(),
        step=0.5 * PERIOD,
        duration=20.0 * PERIOD,
        newton=None,
        initial=mirrored(solid),
    )
    assert motion.energies.strain[0] > 1e4
    assert motion.energies.strain[-1] < 1e-3 * motion.energies.strain[0]
    assert np.abs(motion.state.displacement).max() < 0.1


@pytest.mark.parametrize("integrator", [ImplicitNewmark(), BackwardEuler()])
def test_strong_stiffness_damping_costs_no_more_iterations(integrator):
    """β a hundred periods long: without β K'(u) v in the matrix up to twelve were needed."""
    motion = simulate(
        bar(STVK),
        [Gravity((0.0, 0.0, -2.0))],
        integrator,
        step=0.05,
        duration=0.5,
        damping=(0.0, 1.0),
        newton=None,
    )
    assert max(report.newton_iterations for report in motion.reports) <= 6
    assert all(report.halvings == 0 for report in motion.reports)
    assert np.abs(motion.state.displacement).max() > 0.01


def test_a_linear_solver_that_cannot_begin_ends_a_load_at_once(monkeypatch):
    calls = []

    def fail(self, right_side):
        calls.append(1)
        raise fem_error("conjugate gradients did not converge in 10000 iterations")

    from_fem = __import__("fenics_defo.fem.gradients", fromlist=["JacobiGradients"])
    fem_error = from_fem.SolverError
    monkeypatch.setattr(from_fem.JacobiGradients, "solve", fail)
    with pytest.raises(DivergenceError, match="did not converge in 10000 iterations") as info:
        static_equilibrium(bar(STVK), [Gravity()], linear="pcg-jacobi")
    assert len(calls) == 1
    assert "buckle" not in str(info.value)
    assert "parts as small" not in str(info.value)


def lowest_stiffness(solid, found, bound):
    free = np.flatnonzero(~bound.ravel())
    tangent = solid.tangent(found.displacement).toarray()[np.ix_(free, free)]
    return float(np.linalg.eigvalsh(tangent)[0])


def column():
    """Two cubes between walls, one on the other."""
    return box(
        (1, 1, 2),
        (1.0, 1.0, 2.0),
        kind="hexahedron",
        material=STVK,
        fixed=[fem.Fixed("z>-1", "xy"), fem.Fixed("z==0", "z")],
    )


@pytest.mark.parametrize("height", [0.9, 0.5])
def test_an_equilibrium_is_called_definite_by_its_own_tangent(height, caplog):
    """An even column of StVK is stable above the stretch 1/√3, and not below."""
    solid = column()
    top = solid.points[:, 2] == 2.0
    with caplog.at_level(logging.ERROR):
        found = static_equilibrium(
            solid, [], prescribed=[Prescribed("z==2", (None, None, 2.0 * (height - 1.0)))]
        )
    bound = solid.held | (top[:, None] & np.array([False, False, True]))
    assert found.definite is (lowest_stiffness(solid, found, bound) > 0.0)


def test_an_indefinite_tangent_on_the_way_says_nothing_of_the_end():
    """Pushed through its limit point, St. Venant-Kirchhoff rests beyond it, stably."""
    solid = cube(STVK)
    found = static_equilibrium(solid, [Traction("z==1", (0.0, 0.0, -1.0e5))])
    assert found.definite is (lowest_stiffness(solid, found, solid.held) > 0.0)


def test_messages_name_quantities_not_arguments():
    """The same sentences come from scene files, which know no ``newton=None``."""
    crush = [Prescribed("z==1", (0.0, 0.0, -1.5), Step(0.5))]
    with pytest.raises(DivergenceError) as still:
        static_equilibrium(cube(NEO), [], prescribed=crush, max_halvings=0, max_iterations=3)
    with pytest.raises(DivergenceError) as moving:
        simulate(
            cube(NEO),
            [],
            ImplicitNewmark(),
            step=1.0,
            duration=1.0,
            prescribed=crush,
            max_halvings=0,
            newton=None,
            newton_iterations=1,
        )
    for text in (str(still.value), str(moving.value)):
        assert "=" not in text
        assert "backward Euler" in text
