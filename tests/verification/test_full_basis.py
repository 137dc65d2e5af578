"""A reduced model of all free components is the full simulation: every law, every integrator."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from bodies import Array, box
from motions import EXPLICIT, INTEGRATORS, states

from fenics_defo.analysis import Gravity, Initial, Sine, Traction
from fenics_defo.energy import (
    Corotational,
    Invertible,
    LinearElastic,
    MassSpring,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.fem import Solid
from fenics_defo.reduction import basis_from_array, reduce
from fenics_defo.runtime import integrators
from fenics_defo.runtime.integrators import Stepper

MODULI = {"young": 2.0e4, "poisson": 0.3, "density": 1000.0}
FORCES = {
    "linear": ("linear", LinearElastic(**MODULI)),
    "linear as cubic": ("cubic", LinearElastic(**MODULI)),
    "st-venant-kirchhoff": ("cubic", StVenantKirchhoff(**MODULI)),
    "neo-hookean": ("direct", NeoHookean(**MODULI)),
    "mooney-rivlin": ("direct", MooneyRivlin(c10=3e3, c01=1e3, bulk=2e4, density=1000.0)),
    "corotational": ("direct", Corotational(**MODULI)),
    "invertible": ("direct", Invertible(NeoHookean(**MODULI), threshold=0.5)),
    "mass-spring": ("direct", MassSpring(young=2.0e4, density=1000.0)),
}
STEPPERS: dict[str, type[Stepper]] = {
    "newmark": integrators.ImplicitNewmark,
    "backward-euler": integrators.BackwardEuler,
    "central-differences": integrators.CentralDifferences,
    "symplectic-euler": integrators.SymplecticEuler,
}
STEPS = 8


@cache
def tiny(law: str) -> Solid:
    mesh = box("hexahedron", (2, 1, 1), (0.6, 0.3, 0.25))
    return Solid(mesh, FORCES[law][1], fixed=["x==0"])


def unit_shapes(solid: Solid) -> Array:
    """One shape for each component that is free."""
    rows, components = np.nonzero(~solid.held)
    shapes = np.zeros((len(rows), *solid.points.shape))
    shapes[np.arange(len(rows)), rows, components] = 1.0
    return shapes


def worst_difference(
    law: str, method: str, *, damping: tuple[float, float] = (0.0, 0.0), newton: int | None = 1
) -> float:
    """Of displacement, velocity and acceleration over time, each by its largest value."""
    force, solid = FORCES[law][0], tiny(law)
    free, explicit = ~solid.held, method in EXPLICIT
    x, y, z = solid.points.T
    bend = 0.4 * np.column_stack([-x * z, 0.2 * x * y, x**2])
    spin = 0.5 * np.column_stack([x * y, x * z, -x])
    traction = Traction("x==0.6", (200.0, 0.0, 900.0), Sine(frequency=3.0, phase=1.0))
    step = 2e-3 if explicit else 0.02
    options: dict[str, Any] = {} if explicit else {"newton": newton, "newton_tolerance": 1e-12}
    full = states(
        solid,
        INTEGRATORS[method],
        step=step,
        count=STEPS,
        damping=damping,
        loads=[Gravity(), traction],
        initial=Initial(displacement=bend, velocity=spin),
        **options,
    )
    model = reduce(
        solid,
        basis_from_array(solid, unit_shapes(solid)),
        force,
        loads={"end": traction},
        damping=damping,
        mass="lumped" if explicit else "consistent",
        range_tolerance=None,
    )
    weight = model.gravity((0.0, 0.0, -9.81))

    def load(time: float) -> Array:
        return weight + traction.history(time) * model.load("end")

    stepper = STEPPERS[method](
        model, step=step, q=bend[free], v=spin[free], load=load(0.0), **options
    )
    apart = []
    for state in full:
        if state.step:
            stepper.advance(load(stepper.load_time))
        assert stepper.time == pytest.approx(state.time)
        apart.append(
            [
                np.abs(mine - theirs[free]).max()
                for mine, theirs in (
                    (stepper.q, state.displacement),
                    (stepper.v, state.velocity),
                    (stepper.a, state.acceleration),
                )
            ]
        )
        np.testing.assert_allclose(model.displacement(stepper.q)[free], stepper.q)
    scale = [
        max(np.abs(getattr(state, name)).max() for state in full)
        for name in ("displacement", "velocity", "acceleration")
    ]
    return float((np.max(apart, axis=0) / scale).max())


@pytest.mark.parametrize("method", STEPPERS)
@pytest.mark.parametrize("law", FORCES)
def test_it_is_the_full_simulation(law: str, method: str) -> None:
    assert worst_difference(law, method, damping=(0.7, 0.0)) < 1e-12


@pytest.mark.parametrize("law", ["linear", "st-venant-kirchhoff", "corotational"])
@pytest.mark.parametrize("method", ["newmark", "backward-euler"])
def test_so_it_is_with_stiffness_damping_and_converged(law: str, method: str) -> None:
    assert worst_difference(law, method, damping=(0.7, 4e-3), newton=None) < 1e-12
    assert worst_difference(law, method, damping=(0.7, 4e-3), newton=2) < 1e-12


@pytest.mark.parametrize("law", ["linear", "st-venant-kirchhoff"])
@pytest.mark.parametrize("method", EXPLICIT)
def test_explicit_methods_with_stiffness_damping(law: str, method: str) -> None:
    """The full simulation has K v as a difference of forces, good to half of the digits."""
    assert worst_difference(law, method, damping=(0.7, 2e-4)) < 1e-6


def test_motions_are_far_from_linear() -> None:
    """Else the comparisons above would say nothing about the nonlinear forces."""
    full = {
        name: states(
            tiny(name),
            INTEGRATORS["newmark"],
            step=0.02,
            count=STEPS,
            loads=[Gravity(), Traction("x==0.6", (200.0, 0.0, 900.0))],
        )[-1].displacement
        for name in ("linear", "st-venant-kirchhoff", "neo-hookean")
    }
    size = np.abs(full["linear"]).max()
    assert np.abs(full["linear"] - full["st-venant-kirchhoff"]).max() > 0.02 * size
    assert np.abs(full["neo-hookean"] - full["st-venant-kirchhoff"]).max() > 0.005 * size
