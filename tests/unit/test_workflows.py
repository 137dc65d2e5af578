"""The workflows run on coarse meshes, assert what they show, and write it."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# What each table must tell of.
TOLD = {
    "solvers": ("cholesky", "pcg-jacobi", "pcg-amg", "1e+04", "1e+10"),
    "travelling_load": ("reciprocity", "line of influence", "dynamic amplification"),
    "recovery": ("flattened", "scrambled", "inside out"),
    "benchmark_dynamics": ("StVK", "corotational", "residual", "tangent", "factorise", "rest"),
    "benchmark_runtime": (
        *("floor", "symplectic Euler", "times real time"),
        *("tetrahedra", "derivatives"),
    ),
    "benchmark_cubature": ("floor", "held out", "Cubic or cubature", "Training", "solve"),
    "cubature_training": ("thinned", "greedy", "ecsw", "sampled", "exact cubic force"),
    "spoon": ("linear, 6 modes", "r = 12 with derivatives", "50,000 times"),
    "bridge": ("static fields", "one Newton iteration", "108,000 times"),
    "heart": ("pressure that follows", "on the surface at rest", "cubature of", "21,000 times"),
    "baskets": ("a step of the batch", "with contact", "against single runs"),
    "cantilever": ("neo-Hookean, cubature", "Mooney-Rivlin, cubature", "own frames", "turns by"),
}


@pytest.mark.mpi  # some measure times or two ranks: all leave the cores alone meanwhile
@pytest.mark.parametrize("name", TOLD)
def test_quick_workflow(name: str, tmp_path: Path) -> None:
    script = ROOT / "workflows" / f"{name}.py"
    done = subprocess.run(
        [sys.executable, "-W", "error", script, "--quick", "--output", tmp_path],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    text = (tmp_path / f"{name}.md").read_text()
    assert text.strip() == done.stdout.strip()
    for word in TOLD[name]:
        assert word in text
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert len(list(tmp_path.iterdir())) == 2
