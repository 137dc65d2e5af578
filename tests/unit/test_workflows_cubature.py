"""The workflows of cubature run, assert what they show, and write it."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# What each table must tell of.
TOLD = {
    "benchmark_cubature": ("floor", "held out", "Cubic or cubature", "Training", "solve"),
    "cubature_training": ("thinned", "greedy", "ecsw", "sampled", "exact cubic force"),
}


@pytest.mark.parametrize("name", TOLD)
def test_quick_workflow_of_cubature(name: str, tmp_path: Path) -> None:
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
