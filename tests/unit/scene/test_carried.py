"""What a model carries of a scene, and what it refuses to play."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo import runtime
from fenics_defo.errors import DefoError, DivergenceError, FileFormatError, SceneError
from fenics_defo.scene import Recipe, Watcher, parse_scene, play, read_scene, reduce_scene, simulate
from fenics_defo.scene.carried import body_identity, load_names
from tests.cli.cli_files import strict_json
from tests.unit.scene.two_cells import IMPULSES, INITIAL, SCENE, write_mesh, write_scene

# Hides all but NumPy, the standard library and the package itself.
BARE = """
import sys

class NumpyAlone:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in {"numpy", "fenics_defo", *sys.stdlib_module_names}:
            raise ModuleNotFoundError(f"{name} is hidden", name=name)

sys.meta_path.insert(0, NumpyAlone())
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of the scene with all its loads and a start, in a folder with its mesh."""
    folder = tmp_path_factory.mktemp("carried")
    scene = write_scene(folder, SCENE + INITIAL + IMPULSES)
    reduce_scene(scene, folder / "model.npz", recipe=Recipe(modes=4, size=6))
    return folder / "model.npz"


@pytest.fixture
def scene(model: Path) -> Callable[..., Path]:
    """Write a scene beside the model, with a piece of text replaced."""

    def write(old: str = "", new: str = "", *, more: str = INITIAL + IMPULSES) -> Path:
        text = SCENE + more
        assert old in text
        return write_scene(model.parent, text.replace(old, new, 1), "changed.toml")

    return write


def test_names_say_what_acts_where(model: Path) -> None:
    parsed = parse_scene(model.parent / "scene.toml")
    names = [load_names(parsed, number) for number in range(len(parsed.loads))]
    axes = [f" along {axis}" for axis in "xyz"]
    places = ["traction on 'roof'", "force at (0.4, 0.3, 0.75) m", "momentum of 'z>0.9'"]
    expected = [tuple(place + axis for axis in axes) for place in [*places, "force at node 11"]]
    assert names == [(), *expected]
    carried = runtime.load(model)
    assert {name for group in names for name in group} <= set(carried.loads)


def test_amounts_directions_and_histories_may_change(
    model: Path, scene: Callable[..., Path], tmp_path: Path
) -> None:
    """Twice the force and a force turned round are what they say, by linearity at the start."""

    def tip(path: Path, name: str) -> Any:
        play(model, path, tmp_path / name)
        table = np.genfromtxt(tmp_path / name / "probes.csv", delimiter=",", names=True)
        return np.array([table[f"tip_{axis}"][3] for axis in "xyz"])

    alone = """
[mesh]
file = "two.msh"
[[material]]
law = "st-venant-kirchhoff"
young = 1e6
poisson = 0.3
density = 1000
[[fixed]]
region = "floor"
[[load]]
kind = "traction"
region = "roof"
vector = [1, 0, 0]
[time]
integrator = "backward-euler"
step = 1e-3
duration = 3e-3
[output]
vtk = false
[[probe]]
name = "tip"
point = [0.2, 0.15, 1]
"""
    plain = tip(write_scene(model.parent, alone, "changed.toml"), "a")
    back = tip(write_scene(model.parent, alone.replace("[1, 0", "[-2.0, 0"), "changed.toml"), "b")
    np.testing.assert_allclose(back, -2.0 * plain, rtol=1e-4, atol=1e-4 * np.abs(plain).max())
    ramp = alone.replace("[1, 0, 0]", '[1, 0, 0]\nhistory = { kind = "step", start = 1 }')
    none = tip(write_scene(model.parent, ramp, "changed.toml"), "c")
    np.testing.assert_array_equal(none, 0.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("young = 1e6", "young = 2e6", r"\[\[material\]\] differs"),
        ('region = "floor"', 'region = "roof"', r"\[\[fixed\]\] differs"),
        ('file = "two.msh"', 'file = "two.msh"\norder = 2', r"\[mesh\] differs"),
        (
            'region = "roof"',
            'region = "floor"',
            r"\[\[load\]\] 2: .* carries no traction on 'floor'",
        ),
        ("[0.4, 0.3, 0.75]", "[0.4, 0.3, 0.5]", r"no force at \(0\.4, 0\.3, 0\.5\) m, only"),
        ("node = 11", "node = 10", "no force at node 10"),
        ("mode = 2", "mode = 3", r"\[initial\]: .* carries no 'mass times mode 3'"),
        ("[0.1, 0.2, 0.6]", "[0.1, 0.2, 0.5]", r"inside: .*, only tip at \(0\.2, 0\.15, 1\.0\) m"),
        ('name = "tip"', 'name = "top"', r"\[\[probe\]\] top: "),
        (
            'region = "floor"',
            'region = "floor"\ndisplacement = [0, 0, 1]',
            r"\[\[fixed\]\]",
        ),
        (
            '"implicit-newmark"\nstep = 1e-3',
            '"central-differences"\nstep = 0.04',
            r"changed\.toml: \[time\]: the step of 0\.04 s",
        ),
    ],
)
def test_a_scene_that_the_model_cannot_play(
    model: Path, scene: Callable[..., Path], tmp_path: Path, old: str, new: str, words: str
) -> None:
    with pytest.raises(DefoError, match=words) as told:
        play(model, scene(old, new), tmp_path / "out")
    assert "changed.toml" in str(told.value)
    assert "\n" not in str(told.value)
    assert not (tmp_path / "out").exists()


def test_whole_numbers_are_the_floats_they_stand_for(
    model: Path, scene: Callable[..., Path], tmp_path: Path
) -> None:
    path = scene("young = 1e6", "young = 1000000")
    assert play(model, path, tmp_path / "out")["status"] == "finished"


def test_another_mesh_is_refused(
    model: Path, scene: Callable[..., Path], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = scene()
    mesh = model.parent / "two.msh"
    try:
        mesh.write_text(mesh.read_text().replace("0.5", "0.6"))
        with pytest.raises(SceneError, match=r"two\.msh is not the mesh that"):
            play(model, path, tmp_path / "out")
        mesh.unlink()  # on the machine where a model runs there may be none
        assert play(model, path, tmp_path / "out")["status"] == "finished"
        assert "nothing tells whether it is the model's" in caplog.text
    finally:
        write_mesh(mesh)


def test_a_model_of_no_scene(model: Path, tmp_path: Path) -> None:
    bare = runtime.ReducedModel(
        law=runtime.LinearForce(np.eye(2)),
        mass=np.eye(2),
        outputs=runtime.Outputs(
            nodes=np.arange(1), points=np.zeros((1, 3)), shapes=np.zeros((1, 3, 2))
        ),
        gravity_rows=np.zeros((3, 2)),
    )
    bare.save(tmp_path / "bare.npz")
    with pytest.raises(SceneError, match="was not reduced from a scene"):
        play(tmp_path / "bare.npz", model.parent / "scene.toml", tmp_path / "out")
    (tmp_path / "cut.npz").write_bytes(model.read_bytes()[:1000])
    with pytest.raises(FileFormatError, match=r"cut\.npz"):
        play(tmp_path / "cut.npz", model.parent / "scene.toml", tmp_path / "out")


def test_results_of_a_simulation_are_not_lost(model: Path, tmp_path: Path) -> None:
    path = model.parent / "scene.toml"
    simulate(path, tmp_path / "out")
    before = (tmp_path / "out" / "probes.csv").read_bytes()
    with pytest.raises(DefoError, match=r"holds the results of simulate.*--overwrite"):
        play(model, path, tmp_path / "out")
    assert (tmp_path / "out" / "probes.csv").read_bytes() == before
    assert play(model, path, tmp_path / "out", overwrite=True)["status"] == "finished"
    assert play(model, path, tmp_path / "out")["status"] == "finished"
    assert not (tmp_path / "out" / "checkpoint.npz").exists()


def test_playing_needs_numpy_only(model: Path, tmp_path: Path) -> None:
    """The same tables, to the bit, where nothing but NumPy can be imported."""
    path = model.parent / "scene.toml"
    here = play(model, path, tmp_path / "here")
    code = BARE + "import fenics_defo.cli.defo as d; sys.exit(d.main(sys.argv[1:]))"
    arguments = ["play", str(model), str(path), "--output", str(tmp_path / "there"), "--json"]
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    there = strict_json(done.stdout)
    assert there["probes"] == here["probes"]
    for name in here["files"]:
        assert (tmp_path / "there" / name).exists()
    for name in ("probes.csv", "energy.csv"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()
    done = subprocess.run(
        [sys.executable, "-c", code, "info", str(model), "--json"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert strict_json(done.stdout)["size"] == 6


def test_a_mass_of_the_other_kind_is_told(
    model: Path, scene: Callable[..., Path], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    play(model, scene(), tmp_path / "out")
    assert caplog.text == ""
    play(model, scene("implicit-newmark", "central-differences"), tmp_path / "out")
    assert "the model's mass is consistent; simulate takes the lumped one" in caplog.text


def test_an_interrupted_run_keeps_its_rows(model: Path, tmp_path: Path) -> None:
    asked: list[int] = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 5

    record = play(model, model.parent / "scene.toml", tmp_path / "out", watcher=Watcher(stop=stop))
    assert (record["status"], record["steps"]) == ("interrupted", 5)
    assert len((tmp_path / "out" / "probes.csv").read_text().splitlines()) == 1 + 6
    assert record["seconds"]["step"] > 0.0


def test_divergence_keeps_the_last_good_row(
    model: Path, scene: Callable[..., Path], tmp_path: Path
) -> None:
    path = scene(
        '"implicit-newmark"\nstep = 1e-3\nduration = 0.04',
        '"central-differences"\nstep = 0.05\nduration = 50\nallow_unstable = true',
    )
    with pytest.raises(DivergenceError):
        play(model, path, tmp_path / "out")
    record = strict_json((tmp_path / "out" / "summary.json").read_text())
    assert record["status"] == "failed"
    table = np.genfromtxt(tmp_path / "out" / "probes.csv", delimiter=",", skip_header=1)
    assert len(table) >= record["steps"] > 0
    assert np.isfinite(table).all()


FLIGHT = SCENE.replace('[[fixed]]\nregion = "floor"\n', "")
GRAVITY_ALONE = (
    FLIGHT[: FLIGHT.index('[[load]]\nkind = "traction"')]
    + "\n[time]\n"
    + ('integrator = "implicit-newmark"\nstep = 1e-3\nduration = 5e-3\n')
)


def test_what_flies_knows_gravity_alone(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    scene = write_scene(tmp_path, GRAVITY_ALONE)
    model = reduce_scene(scene, tmp_path / "model.npz", recipe=Recipe(modes=3, size=5))
    assert model.frame is not None
    pushed = write_scene(tmp_path, FLIGHT[: FLIGHT.index("[[probe]]")], "changed.toml")
    with pytest.raises(SceneError, match=r"\[\[load\]\] 2: nothing holds .* no traction"):
        play(tmp_path / "model.npz", pushed, tmp_path / "out")
    static = GRAVITY_ALONE.replace("implicit-newmark", "static")
    with pytest.raises(SceneError, match=r"\[time\]: nothing holds the body"):
        play(tmp_path / "model.npz", write_scene(tmp_path, static, "c.toml"), tmp_path / "out")
    euler = GRAVITY_ALONE.replace("implicit-newmark", "backward-euler")
    play(tmp_path / "model.npz", write_scene(tmp_path, euler, "c.toml"), tmp_path / "out")
    assert "by the trapezoidal rule, not by backward-euler" in caplog.text


def test_scenes_are_known_by_their_text(model: Path) -> None:
    path = model.parent / "scene.toml"
    assert body_identity(read_scene(path)) == body_identity(parse_scene(path))
