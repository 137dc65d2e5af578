"""Each method goes on from a checkpoint to the same bits, with all that can act on a body."""

from pathlib import Path

import pytest

from fenics_defo.scene import Watcher, simulate
from tests.cli.cli_files import write_box

SCENE = """
[mesh]
file = "box.msh"
[[material]]
law = "neo-hookean"
young = 1e6
poisson = 0.3
density = 1000
[[fixed]]
region = "wall"
[[fixed]]
region = "x>3.9 and z<0.1"
components = ["y"]
displacement = [0.05]
history = {{ kind = "ramp", duration = {duration} }}
[[load]]
kind = "gravity"
[[load]]
kind = "pressure"
region = "x>3.9"
value = 2e3
{impulse}
[damping]
mass = 0.5
stiffness = 1e-4
[time]
integrator = "{integrator}"
step = {step}
duration = {duration}
[[probe]]
name = "tip"
point = [4, 0.3, 0.5]
"""
IMPULSE = """
[[load]]
kind = "impulse"
region = "far"
vector = [0, 30, 0]
time = {time}
"""


@pytest.mark.parametrize(
    ("integrator", "step"),
    [
        ("implicit-newmark", 0.02),
        ("backward-euler", 0.02),
        ("central-differences", 0.001),
        ("symplectic-euler", 0.001),
        ("static", 0.1),
    ],
)
def test_the_same_bits(tmp_path: Path, integrator: str, step: float) -> None:
    write_box(tmp_path / "box.msh")
    impulse = "" if integrator == "static" else IMPULSE.format(time=4 * step)
    text = SCENE.format(integrator=integrator, step=step, duration=6 * step, impulse=impulse)
    scene = tmp_path / "scene.toml"
    scene.write_text(text)
    whole = simulate(scene, tmp_path / "whole")
    for stop in (2, 5):  # before the impulse and after it
        asked = iter(range(100))
        watcher = Watcher(stop=lambda asked=asked, stop=stop: next(asked) >= stop)  # type: ignore[misc]
        out = tmp_path / f"stopped-{stop}"
        assert simulate(scene, out, watcher=watcher)["steps"] == stop
        assert simulate(scene, out, restart=True)["energies"] == whole["energies"]
        for name in ("probes.csv", "energy.csv"):
            assert (out / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
