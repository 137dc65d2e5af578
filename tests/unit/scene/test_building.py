"""What a scene's tables become: loads, motions, methods and the state at time zero."""

from pathlib import Path

import numpy as np
import pytest

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Impulse,
    PointLoad,
    Pressure,
    QuasiStatic,
    SymplecticEuler,
    Traction,
)
from fenics_defo.fem import Solid
from fenics_defo.scene import (
    Scene,
    build_initial,
    build_integrator,
    build_loads,
    build_prescribed,
    build_simulation,
    build_solid,
    read_scene,
)
from tests.cli.cli_files import Box, write_box

HEAD = """
[mesh]
file = "box.msh"
[[material]]
young = 1e6
poisson = 0.3
density = 1000
"""
DYNAMIC = '[time]\nintegrator = "backward-euler"\nstep = 0.1\nduration = 2\n'
STATIC = '[time]\nintegrator = "static"\nduration = 2\n'
HELD = '[[fixed]]\nregion = "wall"\n'


@pytest.fixture(scope="module")
def box(tmp_path_factory: pytest.TempPathFactory) -> Box:
    return write_box(tmp_path_factory.mktemp("building") / "box.msh")


def scene_of(box: Box, text: str) -> Scene:
    path = box.path.with_name("scene.toml")
    path.write_text(HEAD + text)
    return read_scene(path)


def built(box: Box, text: str) -> tuple[Scene, Solid]:
    scene = scene_of(box, text)
    return scene, build_solid(scene)


def test_loads(box: Box) -> None:
    text = f"""
[[load]]
kind = "gravity"
vector = [0, -1, 0]
history = {{ kind = "ramp", start = 1, duration = 2 }}
[[load]]
kind = "traction"
region = "x>3.9"
vector = [1, 2, 3]
[[load]]
kind = "pressure"
region = 5
value = 7
history = {{ kind = "table", times = [0, 1], values = [0, 4] }}
[[load]]
kind = "point"
node = {box.numbers[6]}
vector = [1, 0, 0]
history = {{ kind = "pulse", start = 1, duration = 0.5 }}
[[load]]
kind = "impulse"
region = "near"
vector = [0, 5, 0]
time = 0.25
"""
    scene, solid = built(box, DYNAMIC + text)
    gravity, traction, pressure, point, impulse = build_loads(scene, solid)
    assert isinstance(gravity, Gravity)
    assert gravity.vector == (0.0, -1.0, 0.0)
    assert [gravity.history(t) for t in (0.5, 2.0, 4.0)] == [0.0, 0.5, 1.0]
    assert isinstance(traction, Traction)
    assert (traction.region, traction.vector) == ("x>3.9", (1.0, 2.0, 3.0))
    assert [traction.history(t) for t in (0.0, 1.0)] == [1.0, 1.0]  # always there
    assert isinstance(pressure, Pressure)
    assert (pressure.region, pressure.value, pressure.history(0.5)) == (5, 7.0, 2.0)
    assert isinstance(point, PointLoad)
    assert point.node is not None
    np.testing.assert_array_equal(solid.points[point.node], box.points[6])
    assert [point.history(t) for t in (0.9, 1.2, 1.6)] == [0.0, 1.0, 0.0]
    assert isinstance(impulse, Impulse)
    assert (impulse.region, impulse.time) == ("near", 0.25)


def test_in_statics_loads_grow_with_time(box: Box) -> None:
    text = """
[[load]]
kind = "gravity"
[[load]]
kind = "gravity"
history = { kind = "step" }
[[fixed]]
region = "x>3.9"
components = ["z"]
displacement = [0.3]
"""
    scene, solid = built(box, STATIC + HELD + text)
    grows, stays = build_loads(scene, solid)
    (moved,) = build_prescribed(scene)
    assert not isinstance(grows, Impulse)
    assert not isinstance(stays, Impulse)
    assert [grows.history(t) for t in (0.0, 0.5, 2.0)] == [0.0, 0.25, 1.0]
    assert stays.history(0.1) == 1.0
    assert [moved.history(t) for t in (0.0, 0.5, 2.0)] == [0.0, 0.25, 1.0]
    assert tuple(moved.displacement) == (None, None, 0.3)


def test_moved_nodes_follow_and_are_not_held(box: Box) -> None:
    text = """
[[fixed]]
region = "x>3.9"
components = ["z", "x"]
displacement = [0.1, -0.2]
history = { kind = "ramp", duration = 1 }
[[probe]]
name = "end"
point = [4, 0.5, 0.25]
"""
    scene, solid = built(box, DYNAMIC + HELD + text)
    assert solid.held.sum() == 27  # the wall's nine nodes alone
    with build_simulation(scene, solid) as simulation:
        for _ in range(5):
            simulation.advance()
        x, _, z = simulation.probe("end")
    assert (x, z) == pytest.approx((-0.1, 0.05))


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("backward-euler", BackwardEuler()),
        ("central-differences", CentralDifferences()),
        ("symplectic-euler", SymplecticEuler()),
        ("static", QuasiStatic()),
        ("implicit-newmark", ImplicitNewmark()),
    ],
)
def test_methods(box: Box, name: str, method: object) -> None:
    scene = scene_of(box, DYNAMIC.replace("backward-euler", name))
    assert build_integrator(scene.time) == method


def test_newmark_with_its_numbers(box: Box) -> None:
    text = DYNAMIC.replace("backward-euler", "implicit-newmark") + "beta = 0.3\ngamma = 0.6\n"
    assert build_integrator(scene_of(box, text).time) == ImplicitNewmark(beta=0.3, gamma=0.6)


def test_initial_motion_is_rigid(box: Box) -> None:
    text = "[initial]\ndisplacement = [0, 0, 5]\nvelocity = [1, 0, 0]\nspin = [0, 0, 2]\n"
    scene, solid = built(box, DYNAMIC + text)
    u, v = build_initial(scene, solid).fields(len(solid.points))
    np.testing.assert_array_equal(u, np.broadcast_to([0.0, 0.0, 5.0], u.shape))
    x, y, _ = (solid.points - [2.0, 0.5, 0.25]).T
    np.testing.assert_allclose(v, np.stack([1.0 - 2.0 * y, 2.0 * x, 0.0 * x], axis=1), atol=1e-12)


@pytest.mark.parametrize("factor", [0.0, -1.0])
def test_initial_stretch(box: Box, factor: float) -> None:
    scene, solid = built(box, f"{DYNAMIC}[initial]\nstretch = [1, 1, {factor}]\n")
    u, _ = build_initial(scene, solid).fields(len(solid.points))
    expected = solid.points.copy()
    expected[:, 2] = 0.25 + factor * (expected[:, 2] - 0.25)
    np.testing.assert_allclose(solid.points + u, expected, atol=1e-12)


def test_initial_mode_is_elastic_and_keeps_the_supports(box: Box) -> None:
    text = "[initial]\nmode = 1\namplitude = 0.02\n"
    for held in ("", HELD):
        scene, solid = built(box, DYNAMIC + held + text)
        u, _ = build_initial(scene, solid).fields(len(solid.points))
        assert np.linalg.norm(u, axis=1).max() == pytest.approx(0.02)
        assert not u[solid.held].any()
        if not held:  # no part of it moves the body as a whole
            mean = solid.lumped_mass() @ u / solid.total_mass()
            assert np.abs(mean).max() < 1e-3 * 0.02


def test_node_files_lie_beside_the_scene(box: Box, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere = box.path.parent / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    rows = np.flatnonzero(box.points[:, 0] == 0.0)
    (box.path.parent / "wall.bou").write_text(",".join(map(str, box.numbers[rows])))
    scene = scene_of(box, DYNAMIC + '[[fixed]]\nregion = "nodes:wall.bou"\n')
    held = build_solid(scene).held
    np.testing.assert_array_equal(np.flatnonzero(held.any(axis=1)), rows)
    monkeypatch.chdir(box.path.parent)
    relative = read_scene(Path("scene.toml"))
    np.testing.assert_array_equal(build_solid(relative).held, held)
