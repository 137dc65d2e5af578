"""Bodies that nothing holds: fall, flight, momentum, angular momentum, energy."""

import numpy as np
import pytest
from bodies import Array
from motions import CONSTANTS, EXPLICIT, INTEGRATORS, bar, states

from fenics_defo.analysis import Gravity, Initial, Motion, Simulation, State, simulate
from fenics_defo.energy import Corotational, NeoHookean, StVenantKirchhoff
from fenics_defo.fem import Solid

each_integrator = pytest.mark.parametrize("name", INTEGRATORS)
SPIN = np.array([0.4, -0.7, 1.1])
VELOCITY = np.array([0.3, 0.2, -0.5])


def tumbling(solid: Solid, spin: Array = SPIN) -> Initial:
    """A rigid motion, and a strain of some percent to begin with."""
    x = solid.points - solid.points.mean(axis=0)
    strain = np.array([[0.06, 0.03, 0.0], [0.03, -0.04, 0.02], [0.0, 0.02, 0.05]])
    return Initial(displacement=x @ strain, velocity=VELOCITY + np.cross(spin, x))


def momenta(solid: Solid, state: State, *, lumped: bool) -> tuple[Array, Array]:
    """Momentum and angular momentum about the origin, with the mass that the method works with."""
    if lumped:
        carried = solid.lumped_mass()[:, None] * state.velocity
    else:
        carried = (solid.mass() @ state.velocity.ravel()).reshape(-1, 3)
    now = solid.points + state.displacement
    return carried.sum(axis=0), np.cross(now, carried).sum(axis=0)


def losses(solid: Solid, name: str) -> tuple[float, float]:
    """Largest relative changes of momentum and angular momentum over a hundred steps."""
    found = states(
        solid, INTEGRATORS[name], step=0.004, count=100, newton=None, initial=tumbling(solid)
    )
    assert np.abs(found[-1].displacement).max() > 0.2
    pairs = [momenta(solid, state, lumped=name in EXPLICIT) for state in found]
    assert pairs[0][0] == pytest.approx(solid.total_mass() * VELOCITY, rel=1e-9)
    linear, angular = (np.array(kind) for kind in zip(*pairs, strict=True))
    return (
        float(np.abs(linear - linear[0]).max() / np.linalg.norm(linear[0])),
        float(np.abs(angular - angular[0]).max() / np.linalg.norm(angular[0])),
    )


@each_integrator
def test_momentum_is_kept(name: str) -> None:
    """Exactly by all; angular momentum exactly by the explicit methods."""
    linear, angular = losses(bar(StVenantKirchhoff, fixed=()), name)
    assert linear < 1e-9
    assert angular < {"newmark": 0.01, "backward-euler": 0.05}.get(name, 1e-11)


@pytest.mark.parametrize(("name", "order"), [("newmark", 2.0), ("backward-euler", 1.0)])
def test_angular_momentum_of_implicit_methods(name: str, order: float) -> None:
    """Their loss of angular momentum over a given time falls with their order."""
    solid = bar(StVenantKirchhoff, fixed=())
    spin = np.cross(SPIN, solid.points - solid.points.mean(axis=0))
    losses = []
    for count in (40, 80):
        found = states(
            solid,
            INTEGRATORS[name],
            step=0.2 / count,
            count=count,
            newton=None,
            newton_tolerance=1e-9,
            initial=Initial(velocity=spin),
        )
        first, last = (momenta(solid, found[i], lumped=False)[1] for i in (0, -1))
        losses.append(np.linalg.norm(last - first))
    assert np.log2(losses[0] / losses[1]) == pytest.approx(order, abs=0.2)


@each_integrator
@pytest.mark.parametrize("law", [StVenantKirchhoff, NeoHookean, Corotational])
def test_free_fall_strains_nothing(name: str, law: type) -> None:
    """Every node falls alike: v = g t for all; u = g t² / 2, or by the method's own sum."""
    solid = bar(law, fixed=())
    g, step, count = np.array([1.0, -2.0, -9.0]), 0.01, 10
    last = states(
        solid, INTEGRATORS[name], step=step, count=count, loads=[Gravity(tuple(g))], newton=None
    )[-1]
    time = step * count
    assert last.velocity == pytest.approx(np.broadcast_to(time * g, last.velocity.shape), rel=1e-7)
    late = {"backward-euler": step, "symplectic-euler": step}.get(name, 0.0)
    fallen = 0.5 * time * (time + late) * g
    assert last.displacement == pytest.approx(
        np.broadcast_to(fallen, last.displacement.shape), rel=1e-7
    )


def tumble(name: str, *, step: float, duration: float) -> Motion:
    """The tumbling body with its energies."""
    solid = bar(StVenantKirchhoff, fixed=())
    return simulate(
        solid,
        [],
        INTEGRATORS[name],
        step=step,
        duration=duration,
        newton=None,
        initial=tumbling(solid),
    )


@each_integrator
def test_energy_of_a_tumbling_body(name: str) -> None:
    """No drift: bounded over many periods of the lowest mode; or only falling (backward Euler)."""
    explicit = name in EXPLICIT
    energies = tumble(name, step=0.004 if explicit else 0.01, duration=3.0).energies
    total, strain = energies.kinetic + energies.strain, energies.strain[0]
    if name == "backward-euler":
        assert (np.diff(total) < 0.0).all()
        return
    half = len(total) // 2
    assert abs(total[half:].mean() - total[1 : half + 1].mean()) < 0.01 * strain
    bound = {"newmark": 0.05, "central-differences": 0.01}.get(name, 0.3)
    assert np.abs(total - total[0]).max() < bound * strain


def test_slow_spin_is_rigid() -> None:
    """A bar that spins slowly turns by a quarter as a rigid body does, but for the stretch that the
    centrifugal force makes, rho spin² length² / E."""
    solid = bar(StVenantKirchhoff, fixed=())
    spin = np.array([0.0, 0.0, 0.2])
    x = solid.points - solid.points.mean(axis=0)
    turn = 0.5 * np.pi / spin[2]

    def observe(simulation: Simulation) -> None:
        seen.append(simulation.state.displacement)

    seen: list[Array] = []
    simulate(
        solid,
        [],
        INTEGRATORS["newmark"],
        step=turn / 50,
        duration=turn,
        newton=None,
        initial=Initial(velocity=np.cross(spin, x)),
        observe=observe,
        energies_every=0,
    )
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    stretch = CONSTANTS["density"] * spin[2] ** 2 / CONSTANTS["young"]
    assert x + seen[-1] == pytest.approx(x @ quarter.T, abs=2.0 * stretch)
