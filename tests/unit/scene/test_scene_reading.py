"""A scene file becomes records; each mistake in it is told with file, table, key and remedy."""

from pathlib import Path

import pytest

from fenics_defo.energy import NeoHookean
from fenics_defo.errors import DefoError, SceneError
from fenics_defo.scene.reading import read_scene

FULL = """
[mesh]
file = "meshes/beam.msh"
order = 2
size = 0.1

[[material]]
law = "neo-hookean"
young = 1e6
poisson = 0.4
density = 1000

[[fixed]]
region = "wall"

[[fixed]]
region = "x>0.9"
components = ["y", "z"]
displacement = [0.1, 0]
history = { kind = "ramp", duration = 2 }

[[load]]
kind = "gravity"

[[load]]
kind = "traction"
region = 7
vector = [0, 0, -1e3]
history = { kind = "sine", frequency = 3, phase = 0.5 }

[[load]]
kind = "pressure"
region = "top"
value = 2e3
history = { kind = "table", times = [0, 1, 3], values = [0, 2, 1] }

[[load]]
kind = "point"
node = 12
vector = [1, 0, 0]
history = { kind = "pulse", start = 0.5, duration = 0.1 }

[[load]]
kind = "impulse"
point = [1, 0, 0.5]
vector = [0, 2, 0]
time = 0.25

[damping]
mass = 0.1
stiffness = 1e-3

[time]
integrator = "implicit-newmark"
step = 0.01
duration = 1
tolerance = 1e-9

[solver]
linear = "pcg-amg"
tolerance = 1e-8

[[probe]]
name = "tip"
point = [1, 0, 0]

[initial]
velocity = [1, 0, 0]
mode = 2
amplitude = 0.05

[output]
every = 5
vtk = false

[require]
tolerance = 0.01
rate = 500
outputs = "x>0.9"
"""

SMALL = """
[mesh]
file = "beam.msh"
[time]
integrator = "backward-euler"
step = 0.1
duration = 1
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_table_arrives(tmp_path: Path) -> None:
    scene = read_scene(write(tmp_path, FULL))
    assert scene.mesh.file == tmp_path / "meshes" / "beam.msh"
    assert (scene.mesh.order, scene.mesh.size) == (2, 0.1)
    assert isinstance(scene.materials[None], NeoHookean)
    held, moved = scene.fixed
    assert (held.components, held.displacement) == ("xyz", None)
    assert (moved.components, moved.displacement) == ("yz", (0.1, 0.0))
    assert moved.history is not None
    assert moved.history.duration == 2.0
    gravity, traction, pressure, point, impulse = scene.loads
    assert gravity.vector == (0.0, 0.0, -9.81)
    assert (traction.region, traction.vector) == (7, (0.0, 0.0, -1e3))
    assert traction.history is not None
    assert (traction.history.frequency, traction.history.phase) == (3.0, 0.5)
    assert pressure.history is not None
    assert (pressure.value, pressure.history.values) == (2e3, (0.0, 2.0, 1.0))
    assert point.history is not None
    assert (point.node, point.history.start) == (12, 0.5)
    assert (impulse.point, impulse.time) == ((1.0, 0.0, 0.5), 0.25)
    assert (scene.damping.mass, scene.damping.stiffness) == (0.1, 1e-3)
    assert (scene.time.newton, scene.time.tolerance, scene.time.steps) == (None, 1e-9, 100)
    assert (scene.solver.linear, scene.solver.tolerance) == ("pcg-amg", 1e-8)
    assert [probe.name for probe in scene.probes] == ["tip"]
    assert (scene.initial.mode, scene.initial.amplitude) == (2, 0.05)
    assert scene.initial.velocity == (1.0, 0.0, 0.0)
    assert (scene.output.every, scene.output.vtk) == (5, False)
    assert (scene.require.tolerance, scene.require.rate) == (0.01, 500.0)


def test_what_is_left_out_has_its_default(tmp_path: Path) -> None:
    scene = read_scene(write(tmp_path, SMALL))
    assert (scene.materials, scene.fixed, scene.loads, scene.probes) == ({}, (), (), ())
    assert scene.time.newton == 1
    assert scene.solver.linear == "cholesky"
    assert scene.output.vtk


@pytest.mark.parametrize(
    ("step", "duration", "steps"), [(0.1, 1.0, 10), (0.1, 0.3, 3), (0.3, 1.0, 4), (1.0, 1.0, 1)]
)
def test_steps_cover_the_duration(tmp_path: Path, step: float, duration: float, steps: int) -> None:
    text = SMALL.replace("step = 0.1", f"step = {step}")
    scene = read_scene(write(tmp_path, text.replace("duration = 1", f"duration = {duration}")))
    assert scene.time.steps == steps


def test_statics_need_no_step(tmp_path: Path) -> None:
    text = '[mesh]\nfile = "a.msh"\n[time]\nintegrator = "static"\n'
    time = read_scene(write(tmp_path, text)).time
    assert time.is_static
    assert (time.steps, time.newton) == (10, None)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[time]", "[tmie]", ["'tmie'", 'did you mean "time"', "[[load]]"]),
        ("[time]", "[[time]]", ["write [time]"]),
        ("[damping]", "top = 1\n[damping]", ["[[load]] 5", "'top'", "region, point, node"]),
        ('file = "meshes/beam.msh"', "", ["[mesh]", "needs the key file", '"beam.msh"']),
        ('file = "meshes/beam.msh"', "file = 3", ["[mesh]", "file", "got 3"]),
        ("order = 2", "order = 3", ["order must be 1 or 2", "got 3"]),
        ("order = 2", "order = true", ["order must be 1 or 2", "got True"]),
        ("size = 0.1", "size = -1", ["size", "above 0 [m]", "got -1"]),
        ("young = 1e6", "yuong = 1e6", ["[[material]]", "'yuong'", 'mean "young"']),
        ('region = "wall"', "", ["[[fixed]] 1", "needs the key region"]),
        ('region = "wall"', 'region = "wall"\nhistory = { kind = "step" }', ["displacement"]),
        ('["y", "z"]', '["y", "w"]', ["[[fixed]] 2", "components", "'w'"]),
        ('["y", "z"]', '["y", "y"]', ["components", "each once"]),
        ("[0.1, 0]", "[0.1]", ["displacement must be 2 numbers", "y, z"]),
        ('"gravity"', '"gravty"', ["[[load]] 1", "kind", 'mean "gravity"', '"impulse"']),
        ("region = 7", "", ["[[load]] 2", "traction", "needs region"]),
        ("region = 7", "region = true", ["region must be a selection"]),
        ("node = 12", "node = 12\npoint = [0,0,0]", ["one of point, node", "point and node"]),
        ("value = 2e3", "vector = [0,0,1]", ["pressure", "'vector'", "region, value"]),
        ("value = 2e3", "value = nan", ["value", "got nan"]),
        ("vector = [0, 0, -1e3]", "vector = [0, -1e3]", ["three numbers [Pa]"]),
        ("vector = [0, 0, -1e3]", "vector = [0, 0, true]", ["three numbers [Pa]"]),
        ('kind = "sine"', 'kind = "sin"', ["history", 'mean "sine"']),
        ("frequency = 3", "frequency = 0", ["[[load]] 2 history", "above 0 [Hz]", "got 0"]),
        ("phase = 0.5", "start = 0.5", ["history", "'start'", "frequency, phase"]),
        ("times = [0, 1, 3]", "times = [0, 3, 1]", ["times must ascend"]),
        ("times = [0, 1, 3]", "times = [0, 1]", ["one of the values each"]),
        ("times = [0, 1, 3]", "times = []", ["times must be a list of numbers"]),
        ("time = 0.25", "time = -1", ["[[load]] 5", "from 0 [s]"]),
        ("mass = 0.1", "mass = -0.1", ["[damping]", "mass", "from 0 [1/s]", "-0.1"]),
        ("implicit-newmark", "newmark", ["integrator", "implicit-newmark", "static"]),
        ("step = 0.01", "step = 0", ["[time]", "step", "above 0", "got 0"]),
        ("step = 0.01", "step = 2", ["step", "up to 1", "got 2"]),
        ("step = 0.01", 'step = "0.01"', ["step", "got '0.01'"]),
        ("duration = 1\n", "", ["needs the key duration"]),
        ("tolerance = 1e-9", "tolerance = 1e-9\nnewton = 1", ["newton beside tolerance"]),
        ("tolerance = 1e-9", "newton = 0", ["newton", "whole number from 1", "got 0"]),
        ("tolerance = 1e-9", "newton = 1.5", ["newton", "whole number from 1"]),
        ('"pcg-amg"', '"pcg"', ["[solver]", "linear", '"pcg-jacobi"']),
        ('name = "tip"', 'name = "a,b"', ["[[probe]] 1", "commas", "'a,b'"]),
        ('name = "tip"', "", ["[[probe]] 1", "needs the key name"]),
        ("amplitude = 0.05", "", ["mode and amplitude belong together"]),
        ("mode = 2", "mode = 0", ["[initial]", "mode", "from 1"]),
        ("vtk = false", "vtk = 0", ["vtk must be true or false"]),
        ("vtk = false", "interval = 0.1", ["every beside interval"]),
        ("rate = 500", "rate = inf", ["[require]", "rate", "inf"]),
        ("rate = 500", "rate = 5_00_", ["not valid TOML", "line"]),
    ],
)
def test_a_mistake_is_one_sentence(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    assert old in FULL
    path = write(tmp_path, FULL.replace(old, new, 1))
    with pytest.raises(DefoError) as caught:
        read_scene(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_keys_of_newmark_belong_to_it(tmp_path: Path) -> None:
    text = SMALL.replace("step = 0.1", "step = 0.1\nbeta = 0.3")
    with pytest.raises(SceneError, match=r"unknown key 'beta'.*backward-euler"):
        read_scene(write(tmp_path, text))
    time = read_scene(write(tmp_path, text.replace("backward-euler", "implicit-newmark"))).time
    assert (time.beta, time.gamma) == (0.3, 0.5)


def test_explicit_integrators_know_no_newton(tmp_path: Path) -> None:
    text = SMALL.replace("backward-euler", "symplectic-euler") + "newton = 1\n"
    with pytest.raises(SceneError, match=r"unknown key 'newton'.*symplectic-euler"):
        read_scene(write(tmp_path, text))


def test_two_probes_of_one_name(tmp_path: Path) -> None:
    probe = '[[probe]]\nname = "a"\npoint = [0, 0, 0]\n'
    with pytest.raises(SceneError, match=r"\[\[probe\]\] 2.*'a'.*taken"):
        read_scene(write(tmp_path, SMALL + probe + probe))


def test_files_that_are_no_scenes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read"):
        read_scene(tmp_path / "missing.toml")
    with pytest.raises(SceneError, match="cannot be read"):
        read_scene(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="UTF-8"):
        read_scene(tmp_path / "binary.toml")
    with pytest.raises(SceneError, match=r"needs the table \[time\]"):
        read_scene(write(tmp_path, '[mesh]\nfile = "a.msh"\n'))
