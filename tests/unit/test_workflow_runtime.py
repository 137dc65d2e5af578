"""The benchmark of the runtime runs, asserts what it shows, and writes it."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.mpi  # it compares times, and wants the cores for itself
def test_quick_benchmark(tmp_path: Path) -> None:
    script = ROOT / "workflows" / "benchmark_runtime.py"
    done = subprocess.run(
        [sys.executable, "-W", "error", script, "--quick", "--output", tmp_path],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    text = (tmp_path / "benchmark_runtime.md").read_text()
    assert text.strip() == done.stdout.strip()
    for word in ("floor", "symplectic Euler", "times real time", "tetrahedra", "derivatives"):
        assert word in text
    assert (tmp_path / "benchmark_runtime.png").read_bytes().startswith(b"\x89PNG")
