"""A map of what is right, inaccurate, refused or diverges when a simulation is pushed to extremes.

Each cell runs in another process, with a limit of time, so that a hang or a crash is a cell, too:

    python workflows/stability.py --output docs            # docs/stability.md and docs/stability/
    python workflows/stability.py --quick                  # a reduced map on the terminal
    python workflows/stability.py --only Spin --only Recovery      # some of the cells

It ends with status 1 if any cell hangs, crashes, gives a silent NaN or a wrong answer called right.
"""

import argparse
import contextlib
import os
import platform
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from workflows.stability_map import (
    bending,
    collapse,
    contrast,
    endurance,
    report,
    spinning,
    stretching,
    time_step,
)
from workflows.stability_map.cases import Case, Cell
from workflows.stability_map.runner import run

SWEEPS = (endurance, time_step, stretching, contrast, bending, collapse, spinning)


def main(argv: list[str] | None = None) -> int:
    """Compute the map, print it, and write it if asked."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--output", type=Path, help="folder for stability.md and stability/*.png")
    parser.add_argument("--quick", action="store_true", help="a reduced map, within half a minute")
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="WORD",
        help="cells whose names hold this; may be given again for others",
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    options = parser.parse_args(argv)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # of the processes to come
    cells = compute(all_cases(quick=options.quick, only=options.only), jobs=options.jobs)
    seconds = sum(cell.seconds for cell in cells)
    text = report.page(cells, seconds, machine=_machine())
    print(text)
    if options.output:
        options.output.mkdir(parents=True, exist_ok=True)
        (options.output / "stability.md").write_text(text, encoding="utf-8")
        report.draw(cells, options.output / "stability")
    return 1 if report.findings(cells) else 0


def all_cases(*, quick: bool, only: Sequence[str] = ()) -> list[Case]:
    """The cells of all sweeps whose names hold one of some words, if there are any."""
    cases = [case for sweep in SWEEPS for case in sweep.cases(quick=quick)]
    if not only:
        return cases
    names = [f"{case.sweep}; {case.row}; {case.column}" for case in cases]
    return [
        case for case, name in zip(cases, names, strict=True) if any(word in name for word in only)
    ]


def compute(cases: list[Case], *, jobs: int = 1) -> list[Cell]:
    """All cells, told on standard error as they come; the long ones begin first."""
    return run(cases, jobs=jobs, told=_tell)


def _tell(cell: Cell) -> None:
    kind = cell.outcome.kind
    error = "" if cell.outcome.error is None else f"{cell.outcome.error:.1e}"
    line = f"{cell.seconds:6.1f} s  {cell.sweep}; {cell.row}; {cell.column}: {kind} {error}"
    print(line if kind.sound else f"{line} {cell.outcome.message}", file=sys.stderr, flush=True)


def _machine() -> str:
    """The processor, where the system tells it, and Python's version."""
    name = platform.machine()
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    return f"{name}, Python {platform.python_version()}"


if __name__ == "__main__":
    sys.exit(main())
