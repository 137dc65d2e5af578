"""The scenes that come with the project, and the one that docs/scenes.md shows."""

import re
from pathlib import Path

import numpy as np
import pytest

from fenics_defo.cli import simulate_options
from fenics_defo.scene import build_simulation, build_solid, read_scene, simulate
from fenics_defo.scene.load_schema import _HISTORY_KEYS, _LOAD_KEYS
from fenics_defo.scene.records import Scene

ROOT = Path(__file__).resolve().parents[3]
SCENES = sorted((ROOT / "scenes").glob("*.toml"))
PAGE = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")


@pytest.fixture
def shown(tmp_path: Path) -> Scene:
    (tmp_path / "meshes").symlink_to(ROOT / "scenes" / "meshes")
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
    (tmp_path / "scene.toml").write_text(text)
    return read_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_each_scene_can_begin(path: Path) -> None:
    scene = read_scene(path)
    assert scene.mesh.file.stat().st_size < 50_000
    with build_simulation(scene, build_solid(scene)) as simulation:
        for probe in scene.probes:
            assert np.isfinite(simulation.probe(probe.name)).all()


def test_the_scene_of_the_page_runs(shown: Scene, tmp_path: Path) -> None:
    with build_simulation(shown, build_solid(shown)) as simulation:
        simulation.advance()
        assert np.isfinite(simulation.state.displacement).all()


def test_page_and_help_name_each_key() -> None:
    keys = {*_LOAD_KEYS, *_HISTORY_KEYS}.union(*_LOAD_KEYS.values(), *_HISTORY_KEYS.values())
    for text in (PAGE, simulate_options.DETAILS):
        assert keys <= set(re.findall(r"\w+", text))


def test_a_slab_in_free_flight(tmp_path: Path) -> None:
    """It comes down as it went up: z = v t - g t² / 2 of the centre, which here is the mean."""
    scene = read_scene(ROOT / "scenes" / "tumbling_slab.toml")
    record = simulate(scene, tmp_path / "out")
    assert record["energies"]["external"] == pytest.approx(0.0, abs=1e-9)
    table = np.genfromtxt(tmp_path / "out" / "energy.csv", delimiter=",", names=True)
    balance = table["kinetic"] + table["strain"] - table["external"]
    np.testing.assert_allclose(balance, balance[0], rtol=5e-3)
    mass = 1000.0 * 0.6 * 0.2 * 0.1
    highest = mass * 9.81 * 4.905**2 / (2.0 * 9.81)  # the work of gravity up there, but for sign
    assert table["external"].min() == pytest.approx(-highest, rel=1e-6)
