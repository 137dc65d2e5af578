"""A floating body's step: what it keeps, its order, its loads, batches, and what it refuses."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mass_clouds import Array, Cloud, cloud

from fenics_defo.errors import DefoError, DivergenceError, LoadError, SolverError, StepSizeError
from fenics_defo.runtime import CubicForce, FloatingBody, Outputs, ReducedModel, load
from fenics_defo.runtime.floating import rotations
from fenics_defo.runtime.integrators import ImplicitNewmark

SPIN = np.array([0.3, 2.0, 0.4])
VELOCITY = np.array([0.5, -0.2, 1.0])
Q, V = np.full(4, 0.2), np.linspace(-0.5, 0.5, 4)
TURN = rotations.exponential(np.array([0.4, -0.2, 0.9]))[0]
each_newton = pytest.mark.parametrize("newton", [1, 2, None])
each_coupling = pytest.mark.parametrize("coupling", ["full", "none"])


def flying(body: Any, *, step: float = 0.02, **options: Any) -> FloatingBody:
    """The body thrown, turning and vibrating."""
    motion = {"rotation": TURN, "velocity": VELOCITY, "angular_velocity": SPIN, "q": Q, "v": V}
    return FloatingBody(body, step=step, **(motion | options))


def run(flyer: FloatingBody, count: int, **loads: Any) -> FloatingBody:
    for _ in range(count):
        flyer.advance(**loads)
    return flyer


@each_coupling
@each_newton
@pytest.mark.parametrize("tisserand", [True, False])
def test_momentum_is_kept_to_round_off(tisserand: bool, newton: int | None, coupling: Any) -> None:
    """Whatever the number of iterations, with steps of a sixth of a radian and more."""
    body = cloud(tisserand=tisserand, stiffness=40.0 if tisserand else 400.0)
    flyer = flying(body, step=0.08, newton=newton, coupling=coupling)
    before = flyer.momentum()
    assert np.linalg.norm(before[1]) > 1.0
    run(flyer, 300)
    assert np.abs(flyer.v - V).max() > 0.1
    for now, then in zip(flyer.momentum(), before, strict=True):
        assert now == pytest.approx(then, abs=2e-13 * np.linalg.norm(then))
    assert flyer.rotation @ flyer.rotation.T == pytest.approx(np.eye(3), abs=1e-15)


def test_momentum_is_that_of_the_points() -> None:
    body = cloud(tisserand=False)
    flyer = run(flying(body), 20)
    places = flyer.world_points()
    inside = (body.shapes - body.frame.mean) @ flyer.v
    velocities = flyer.velocity + np.cross(flyer.angular_velocity, places - flyer.position)
    velocities += inside @ flyer.rotation.T
    carried = body.masses[:, None] * velocities
    linear, angular = flyer.momentum()
    assert linear == pytest.approx(carried.sum(axis=0), rel=1e-12)
    assert angular == pytest.approx(np.cross(places, carried).sum(axis=0), rel=1e-11)
    kinetic = 0.5 * (carried * velocities).sum()
    assert flyer.energies.kinetic == pytest.approx(kinetic, rel=1e-12)
    assert flyer.position == pytest.approx(body.masses @ places / body.masses.sum(), abs=1e-12)


@each_newton
def test_energy_does_not_drift(newton: int | None) -> None:
    """Over tens of turns. Its error is of second order; one iteration a step lets it creep."""
    flyer = flying(cloud(stiffness=400.0), step=0.04, newton=newton, velocity=np.zeros(3))
    found = []
    for _ in range(300):
        energies = run(flyer, 2).energies
        found.append(float(energies.kinetic + energies.strain))
    total = np.array(found) / found[0]
    assert np.ptp(total) < 0.02
    half = len(total) // 2
    assert abs(total[half:].mean() - total[:half].mean()) < (0.002 if newton == 1 else 2e-4)


@each_newton
def test_second_order(newton: int | None) -> None:
    """Also under loads, of position, rotation, deformation and their rates."""
    loads: dict[str, Any] = {
        "load": np.array([0.5, -1.0, 0.2, 0.3]),
        "gravity": (0.0, 1.0, -9.0),
        "forces": [(10, (1.0, 2.0, 3.0)), (14, (-2.0, 1.0, 0.5))],
    }

    def state(count: int) -> list[Array]:
        flyer = run(flying(cloud(), step=0.8 / count, newton=newton), count, **loads)
        return [flyer.q, flyer.v, flyer.rotation, flyer.angular_velocity, flyer.position]

    coarse, middle, fine = state(50), state(100), state(200)
    for a, b, c in list(zip(coarse, middle, fine, strict=True))[:4]:
        order = np.log2(np.linalg.norm(a - b) / np.linalg.norm(b - c))
        assert order == pytest.approx(2.0, abs=0.25)
    assert coarse[4] == pytest.approx(fine[4], abs=1e-12)  # constant forces: exact


def test_there_and_back() -> None:
    """The rule is symmetric: with all rates turned round the motion runs back to its start."""
    body = cloud()
    there = run(flying(body, newton=None, newton_tolerance=1e-13, step=0.05), 40)
    back = FloatingBody(
        body,
        step=0.05,
        newton=None,
        newton_tolerance=1e-13,
        position=there.position,
        rotation=there.rotation,
        velocity=-there.velocity,
        angular_velocity=-there.angular_velocity,
        q=there.q,
        v=-there.v,
    )
    run(back, 40)
    assert back.q == pytest.approx(Q, abs=1e-10)
    assert back.v == pytest.approx(-V, abs=1e-10)
    assert back.rotation == pytest.approx(TURN, abs=1e-10)
    assert back.position == pytest.approx(body.frame.centre, abs=1e-10)


@each_newton
def test_without_rotation_it_is_newmark(newton: int | None) -> None:
    """With no coupling the spin does not matter; nor does Rayleigh's damping for the flight."""
    rng = np.random.default_rng(9)
    law = CubicForce.from_unique(20.0 * np.eye(4), 3.0 * rng.normal(size=20), np.ones(35))
    body = cloud()
    model = ReducedModel(law=law, mass=np.eye(4), frame=body.frame, damping=(0.3, 0.01))
    first, load = np.array([0.2, 0.0, -0.4, 0.1]), np.array([1.0, -2.0, 0.5, 0.0])
    settings: dict[str, Any] = {"step": 0.05, "newton": newton, "newton_tolerance": 1e-12}
    held = ImplicitNewmark(model, q=Q, v=V, load=first, **settings)
    flyer = flying(model, coupling="none", **settings)
    flyer.begin(first)
    for _ in range(60):
        held.advance(load)
        flyer.advance(load)
    assert flyer.q == pytest.approx(held.q, abs=1e-11)
    assert flyer.v == pytest.approx(held.v, abs=1e-11)
    assert flyer.velocity == pytest.approx(VELOCITY, abs=1e-15)


def test_damping_takes_energy_but_no_momentum() -> None:
    flyer = flying(cloud(), damping=(0.5, 0.05), newton=None)
    before, last = flyer.momentum(), np.inf
    for _ in range(300):
        flyer.advance()
        energies = flyer.energies
        total = float(energies.kinetic + energies.strain)
        assert total <= last + 1e-12
        last = total
    assert flyer.momentum()[1] == pytest.approx(before[1], rel=1e-12)


def test_free_fall_deforms_nothing() -> None:
    g = np.array([1.0, -2.0, -9.8])
    flyer = FloatingBody(cloud(tisserand=False), step=0.01, velocity=VELOCITY)
    start = flyer.world_points()
    run(flyer, 50, gravity=g)
    fallen = 0.5 * VELOCITY + 0.125 * g
    assert flyer.world_points() - start == pytest.approx(
        np.broadcast_to(fallen, (12, 3)), abs=1e-13
    )
    assert flyer.velocity == pytest.approx(VELOCITY + 0.5 * g, abs=1e-13)
    assert flyer.time == pytest.approx(0.5)
    assert flyer.steps == 50


def test_forces_change_the_momenta_by_their_impulse() -> None:
    """A constant force on a node: P by F t, and the work of the force is the energy gained."""
    body, force = cloud(), np.array([0.5, 1.0, -0.3])
    flyer = flying(body, step=0.005, newton=None)
    before, energies, work = flyer.momentum(), flyer.energies, 0.0
    place, twist = flyer.world_points()[3], np.zeros(3)
    for _ in range(200):
        flyer.advance(forces=[(13, force)])
        now = flyer.world_points()[3]
        work += float(force @ (now - place))
        twist += 0.5 * 0.005 * np.cross(now + place, force)
        place = now
    linear, angular = flyer.momentum()
    assert linear - before[0] == pytest.approx(force, rel=1e-12)
    assert angular - before[1] == pytest.approx(twist, rel=1e-4)
    gained = flyer.energies.kinetic + flyer.energies.strain - energies.kinetic - energies.strain
    assert gained == pytest.approx(work, rel=5e-3)


def test_shapes_may_carry_rigid_translations() -> None:
    """What a shape moves the centre of mass, the frame moves back: the motion is the same."""
    body = cloud()
    shifted = replace(body, shapes=body.shapes + np.array([[1.0], [-2.0], [0.5]]))
    loads: dict[str, Any] = {"gravity": (0.0, 0.0, -9.8), "forces": [(12, (1.0, 0.0, 2.0))]}
    one, other = (run(flying(each), 50, **loads) for each in (body, shifted))
    assert other.world_points() == pytest.approx(one.world_points(), abs=1e-10)


def test_a_batch_is_many_bodies() -> None:
    body, rng = cloud(), np.random.default_rng(6)
    q, spin, fall = rng.normal(size=(3, 4)), rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    load, force = rng.normal(size=(3, 4)), rng.normal(size=(3, 3))
    turns = rotations.exponential(rng.normal(size=(3, 3)))[0]
    options: dict[str, Any] = {"step": 0.03, "velocity": VELOCITY, "newton": 2}
    every = FloatingBody(body, rotation=turns, q=q, angular_velocity=spin, **options)
    run(every, 30, load=load, gravity=fall, forces=[(11, force), (12, (0.0, 1.0, 0.0))])
    for i in range(3):
        one = FloatingBody(body, rotation=turns[i], q=q[i], angular_velocity=spin[i], **options)
        forces = [(11, force[i]), (12, (0.0, 1.0, 0.0))]
        run(one, 30, load=load[i], gravity=fall[i], forces=forces)
        assert every.world_points()[i] == pytest.approx(one.world_points(), abs=1e-10)
        assert every.momentum()[1][i] == pytest.approx(one.momentum()[1], abs=1e-10)
        assert every.energies.kinetic[i] == pytest.approx(one.energies.kinetic, rel=1e-9)
        assert every.quaternion[i] == pytest.approx(one.quaternion, abs=1e-10)


def test_start_as_given() -> None:
    quaternion = rotations.to_quaternion(TURN)
    flyer = FloatingBody(cloud(), step=0.1, rotation=quaternion, angular_velocity=SPIN)
    assert flyer.rotation == pytest.approx(TURN, abs=1e-15)
    assert flyer.quaternion == pytest.approx(quaternion, abs=1e-15)
    assert flyer.angular_velocity == pytest.approx(SPIN, abs=1e-15)
    resting = FloatingBody(cloud(), step=0.1)
    assert resting.world_displacement() == pytest.approx(0.0, abs=1e-15)
    run(resting, 3)
    assert resting.world_displacement() == pytest.approx(0.0, abs=1e-15)


def test_a_model_from_a_file_flies(tmp_path: Path) -> None:
    """With a cubic force, and with the damping that the model brings."""
    body, rng = cloud(3), np.random.default_rng(2)
    law = CubicForce.from_unique(5.0 * np.eye(3), rng.normal(size=10), rng.normal(size=15))
    outputs = Outputs(nodes=body.nodes, points=body.points, shapes=body.shapes)
    model = ReducedModel(
        law=law, mass=np.eye(3), outputs=outputs, frame=body.frame, damping=(0.1, 0.0)
    )
    model.save(tmp_path / "model.npz")
    again = load(tmp_path / "model.npz")
    first, second = (
        run(FloatingBody(each, step=0.02, angular_velocity=SPIN, v=np.ones(3)), 50)
        for each in (model, again)
    )
    assert np.array_equal(first.world_points(), second.world_points())
    free = replace(body, law=law)
    undamped = run(FloatingBody(free, step=0.02, angular_velocity=SPIN, v=np.ones(3)), 50)
    assert undamped.energies.kinetic + undamped.energies.strain > (
        first.energies.kinetic + first.energies.strain
    )


@dataclass(frozen=True)
class Wall:
    """A law that stops being a number beyond |q| = 1."""

    def evaluator(self, shape: tuple[int, ...]) -> "Wall":
        return self

    def force_and_stiffness(self, q: Array) -> tuple[Array, Array]:
        force = np.where(np.abs(q) < 1.0, q, np.nan)
        return force, np.eye(4)


@each_newton
def test_divergence_keeps_the_last_good_state(newton: int | None) -> None:
    flyer = FloatingBody(replace(cloud(), law=Wall()), step=0.125, newton=newton, v=np.full(4, 2.0))
    with pytest.raises(DivergenceError, match="last good state stands") as caught:
        run(flyer, 100)
    assert np.isfinite(flyer.q).all()
    assert flyer.steps > 1
    assert caught.value.time == flyer.time == pytest.approx(0.125 * flyer.steps)
    assert caught.value.step == 0.125


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"step": 0.0}, StepSizeError, "positive and finite"),
        ({"step": np.nan}, StepSizeError, "positive and finite"),
        ({"damping": (-1.0, 0.0)}, LoadError, "two numbers from 0"),
        ({"damping": 1.0}, LoadError, "two numbers from 0"),
        ({"newton": 0}, SolverError, "whole number from 1, or None"),
        ({"newton": True}, SolverError, "whole number from 1, or None"),
        ({"newton_tolerance": 2.0}, SolverError, "between 0 and 1"),
        ({"newton_iterations": 0}, SolverError, "whole number from 1"),
        ({"coupling": "some"}, DefoError, "'full' or 'none'"),
        ({"q": np.zeros(3)}, LoadError, r"shape \(4,\), or \(b, 4\)"),
        ({"velocity": (0.0, np.nan, 0.0)}, LoadError, "velocity of a floating body must be finite"),
        ({"angular_velocity": "fast"}, LoadError, "angular_velocity of a floating body"),
        ({"rotation": 2.0 * np.eye(3)}, LoadError, "rotation matrix"),
        ({"rotation": -np.eye(3)}, LoadError, "rotation matrix"),
        ({"rotation": (1.0, 1.0, 0.0, 0.0)}, LoadError, "unit quaternion"),
        ({"q": np.zeros((2, 4)), "v": np.zeros((3, 4))}, DefoError, "different sizes"),
    ],
)
def test_arguments_out_of_range(options: dict[str, Any], error: type, words: str) -> None:
    with pytest.raises(error, match=words):
        FloatingBody(cloud(), **({"step": 0.1} | options))


@pytest.mark.parametrize(
    ("loads", "words"),
    [
        ({"load": np.zeros(3)}, r"load of a floating body .* \(4,\)"),
        ({"gravity": (0.0, 0.0, np.inf)}, "gravity of a floating body must be finite"),
        ({"forces": [(3, (0.0, 0.0, 1.0))]}, "node 3 is not stored"),
        ({"forces": [(10, (0.0, 1.0))]}, "a force of a floating body"),
        ({"forces": [(10, 0.0, 1.0)]}, "pair of a node and a vector"),
        ({"gravity": np.zeros((2, 3))}, "for 2 bodies"),
    ],
)
def test_loads_out_of_range(loads: dict[str, Any], words: str) -> None:
    flyer = FloatingBody(cloud(), step=0.1)
    with pytest.raises(LoadError, match=words):
        flyer.advance(**loads)
    assert flyer.steps == 0
    flyer.begin(gravity=(0.0, 0.0, 1.0))
    flyer.advance()
    assert flyer.velocity == pytest.approx([0.0, 0.0, 0.05], abs=1e-15)
    with pytest.raises(DefoError, match="has begun 1 steps ago"):
        flyer.begin()


def test_a_held_body_cannot_fly() -> None:
    @dataclass(frozen=True)
    class Held(Cloud):
        frame = None  # type: ignore[assignment]

    body = cloud()
    held = Held(body.masses, body.points, body.shapes, body.law)
    with pytest.raises(DefoError, match="no floating frame"):
        FloatingBody(held, step=0.1)
