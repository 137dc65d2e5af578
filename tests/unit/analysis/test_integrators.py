"""Integrators against theory: one mode, orders of convergence, energies, conserved quantities."""

from functools import cache

import numpy as np
import pytest
from moving_bodies import LINEAR, STVK, TIP, bar, lowest

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Initial,
    PointLoad,
    Prescribed,
    Pulse,
    Simulation,
    Sine,
    SymplecticEuler,
    simulate,
)

ALPHA = 0.3
NEWMARK, EULER = ImplicitNewmark(), BackwardEuler()
CENTRAL, SYMPLECTIC = CentralDifferences(), SymplecticEuler()
ALL = [NEWMARK, ImplicitNewmark(beta=0.36, gamma=0.7), EULER, CENTRAL, SYMPLECTIC]
IDS = ["average", "newmark", "backward", "central", "symplectic"]


def one_mode_map(integrator, omega, damping, h):
    """(u, v, a) -> (u', v', a') of u'' + c u' + ω² u = 0, by the equations of each method."""
    alpha, beta = damping
    c, k = alpha + beta * omega**2, omega**2
    # M (u', v', a') = N (u, v, a), row by row
    match integrator:
        case ImplicitNewmark(b, g):
            new = [[1.0, 0.0, -b * h**2], [0.0, 1.0, -g * h], [k, c, 1.0]]
            old = [[1.0, h, h**2 * (0.5 - b)], [0.0, 1.0, h * (1.0 - g)], [0.0, 0.0, 0.0]]
        case BackwardEuler():
            new = [[1.0, -h, 0.0], [0.0, 1.0, -h], [k, c, 1.0]]
            old = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]
        case CentralDifferences():
            new = [[1.0, 0.0, 0.0], [0.0, 1.0, -h / 2], [k, alpha, 1.0]]
            stiff = -beta * k
            old = [[1.0, h, h**2 / 2], [0.0, 1.0, h / 2], [0.0, stiff, stiff * h / 2]]
        case SymplecticEuler():
            new = [[1.0, -h, 0.0], [0.0, 1.0, -h], [0.0, alpha, 1.0]]
            old = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-k, -beta * k, 0.0]]
    return np.linalg.solve(new, old)


@pytest.mark.parametrize("damping", [(0.0, 0.0), (ALPHA, 2e-3)])
@pytest.mark.parametrize("integrator", ALL, ids=IDS)
def test_a_mode_of_a_linear_body_moves_as_the_method_moves_one_mass(integrator, damping):
    solid = bar(LINEAR)
    omega, shape = lowest(solid, 1, lumped=integrator.explicit)
    h, amplitude = 0.2 / omega, 1e-3
    if integrator.explicit:
        with Simulation(solid, [], integrator, step=1e-9, damping=damping) as simulation:
            h = 0.9 * simulation.critical_step
    motion = simulate(
        solid,
        [],
        integrator,
        step=h,
        duration=40 * h,
        damping=damping,
        initial=Initial(displacement=amplitude * shape),
    )
    start = -(omega**2) * amplitude
    expected = np.array([amplitude, 0.0, start])
    for _ in range(40):
        expected = one_mode_map(integrator, omega, damping, h) @ expected
    state = motion.state
    assert state.displacement == pytest.approx(expected[0] * shape, abs=1e-7 * amplitude)
    assert state.velocity == pytest.approx(expected[1] * shape, abs=1e-6 * amplitude * omega)


@pytest.mark.parametrize("integrator", ALL, ids=IDS)
def test_period_and_decay_of_a_damped_mode(integrator):
    """u = e^{-ξωt} cos(ω√(1-ξ²) t) in the limit of small steps."""
    solid = bar(LINEAR)
    omega, shape = lowest(solid, lumped=integrator.explicit)
    ratio = ALPHA / (2.0 * omega)
    period = 2.0 * np.pi / (omega * np.sqrt(1.0 - ratio**2))
    steps = 200
    motion = simulate(
        solid,
        [],
        integrator,
        step=period / steps,
        duration=period,
        damping=(ALPHA, 0.0),
        initial=Initial(displacement=1e-3 * shape, velocity=-ratio * omega * 1e-3 * shape),
        energies_every=0,
    )
    step_angle = 2.0 * np.pi / steps
    # Relative errors over one period: 2π (ωh)/2 for methods of first order, (ωh)² of second.
    first = integrator in (EULER, ALL[1])
    allowed = 4.0 * step_angle if first else 4.0 * step_angle**2
    decayed = np.exp(-ratio * omega * period)
    ratio_of_shapes = np.vdot(motion.state.displacement, shape) / np.vdot(shape, shape)
    assert ratio_of_shapes == pytest.approx(1e-3 * decayed, rel=allowed)


@cache
def swing(integrator, steps, damping):
    """A bar bent strongly by a load that begins without a jolt."""
    return simulate(
        bar(STVK),
        [Gravity((0.0, 1.0, 4.0), history=Sine(0.5))],
        integrator,
        step=0.8 / steps,
        duration=0.8,
        damping=damping,
        newton=None,
        newton_tolerance=1e-11,
        probes={"tip": TIP},
    )


# Stiffness damping enters explicit methods half a step late: it is left out for them.
ORDERS = [
    (NEWMARK, (ALPHA, 0.02), 2, 10),
    (EULER, (0.0, 0.0), 1, 80),
    (CENTRAL, (ALPHA, 0.0), 2, 160),
    (SYMPLECTIC, (ALPHA, 0.0), 1, 160),
]
WHICH = ["average", "backward", "central", "symplectic"]


@pytest.mark.parametrize(("integrator", "damping", "order", "steps"), ORDERS, ids=WHICH)
def test_order_of_convergence_on_a_nonlinear_body(integrator, damping, order, steps):
    """From three steps each half the one before: no reference is needed."""
    tips = [swing(integrator, steps * 2**i, damping).probes["tip"][-1] for i in range(3)]
    assert np.linalg.norm(tips[2]) > 0.5
    ratio = np.linalg.norm(tips[1] - tips[0]) / np.linalg.norm(tips[2] - tips[1])
    assert np.log2(ratio) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize(("integrator", "damping", "order", "steps"), ORDERS, ids=WHICH)
def test_energies_balance_to_the_order_of_the_method(integrator, damping, order, steps):
    lacks = []
    for i in range(2):
        energies = swing(integrator, steps * 2**i, damping).energies
        assert energies.dissipated[-1] > 0.0 or not any(damping)
        lacks.append(np.abs(energies.balance).max() / energies.external.max())
    assert 0.0 < lacks[1] < 0.05
    assert np.log2(lacks[0] / lacks[1]) == pytest.approx(order, abs=0.2)


def test_backward_euler_only_takes_energy():
    assert (np.diff(swing(EULER, 80, (0.0, 0.0)).energies.balance) <= 0.0).all()


def test_average_acceleration_balances_exactly_on_linear_bodies():
    solid = bar(LINEAR)
    loads = [
        Gravity((0.0, 0.0, -9.81)),
        PointLoad(point=TIP, vector=(0.0, 3.0, 0.0), history=Pulse(0.1, 0.2)),
    ]
    motion = simulate(
        solid, loads, NEWMARK, step=0.02, duration=1.0, damping=(ALPHA, 1e-3), probes={"tip": TIP}
    )
    energies = motion.energies
    largest = np.abs([energies.kinetic, energies.strain, energies.external]).max()
    assert largest > 0.1
    assert energies.dissipated[-1] > 0.05 * largest
    assert (np.diff(energies.dissipated) >= 0.0).all()
    assert energies.balance == pytest.approx(0.0, abs=1e-9 * largest)


def test_prescribed_motion_does_the_work_that_the_body_takes():
    """A shaken support: external work balances kinetic and strain energy to second order."""
    solid = bar(STVK, held=None)
    lacks = []
    for steps in (40, 80):
        motion = simulate(
            solid,
            [],
            NEWMARK,
            step=0.5 / steps,
            duration=0.5,
            newton=None,
            newton_tolerance=1e-11,
            prescribed=[Prescribed("x==0", (0.0, 0.0, 0.1), history=Sine(1.0))],
            probes={"root": (0.0, 0.1, 0.1), "tip": TIP},
        )
        expected = 0.1 * np.sin(2.0 * np.pi * motion.times)
        assert motion.probes["root"][:, 2] == pytest.approx(expected, abs=1e-15)
        assert np.abs(motion.probes["tip"][:, 2] - expected).max() > 0.02
        energies = motion.energies
        assert np.ptp(energies.external) > 1e-2
        lacks.append(np.ptp(energies.balance) / np.ptp(energies.external))
    assert lacks[1] < 0.02
    assert lacks[0] / lacks[1] > 3.0


@pytest.mark.parametrize("integrator", [CENTRAL, SYMPLECTIC], ids=["central", "symplectic"])
def test_explicit_methods_conserve_both_momenta_of_a_free_body(integrator):
    linear, angular = tumble(integrator, 2e-3)
    assert linear[-1] == pytest.approx(linear[0], rel=1e-12)
    assert angular[-1] == pytest.approx(angular[0], rel=1e-11)


def test_implicit_methods_conserve_momentum_and_angular_momentum_in_the_limit():
    drifts = []
    for step in (8e-3, 4e-3):
        linear, angular = tumble(NEWMARK, step)
        assert linear[-1] == pytest.approx(linear[0], rel=1e-9)
        drifts.append(np.linalg.norm(angular[-1] - angular[0]) / np.linalg.norm(angular[0]))
    assert drifts[1] < 1e-3
    assert drifts[0] / drifts[1] > 3.0


def tumble(integrator, step):
    """A free bar thrown and spun: momentum and angular momentum at the start and the end."""
    solid = bar(STVK, held=None)
    thrown = np.array([1.0, -2.0, 0.5])
    spun = np.cross((1.0, 3.0, 2.0), solid.points - (0.5, 0.15, 0.1))
    momenta = []
    simulate(
        solid,
        [],
        integrator,
        step=step,
        duration=0.4,
        newton=None,
        newton_tolerance=1e-12,
        initial=Initial(velocity=thrown + spun),
        energies_every=0,
        observe=lambda simulation: momenta.append(simulation.momentum()),
    )
    linear, angular = zip(*momenta, strict=True)
    return np.array(linear), np.array(angular)


def test_a_free_body_falls_as_galilei_says():
    """u = g t²/2 exactly for methods of second order: the acceleration is constant."""
    solid = bar(LINEAR, held=None)
    for integrator in (NEWMARK, CENTRAL):
        motion = simulate(solid, [Gravity((0, 0, -9.81))], integrator, step=5e-3, duration=0.1)
        fallen = np.zeros_like(solid.points)
        fallen[:, 2] = -0.5 * 9.81 * 0.1**2
        assert motion.state.displacement == pytest.approx(fallen, abs=1e-10)
        assert motion.energies.balance == pytest.approx(0.0, abs=1e-9)
        assert motion.energies.external[-1] == pytest.approx(60.0 * 9.81**2 * 0.1**2 / 2.0)
