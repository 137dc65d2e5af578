"""The simulator against theory and published results: each number asserted, tabulated and drawn.

    python workflows/validation.py --output docs

writes ``validation.md`` and the figures ``validation/*.png`` into the folder. The cases are those
of ``tests/verification``, here on finer meshes and smaller steps.
"""

import argparse
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "verification")]

from validation_report import Chapter  # noqa: E402

HEAD = """\
# Validation of statics and dynamics

Made by `python workflows/validation.py --output docs`, which stops if a difference exceeds what is
accepted. Differences are relative to the expected number, or absolute where that is zero. The
closed forms are those of `fenics_defo.beams`; `tests/verification` holds more of them, with orders
of convergence, on coarser meshes.
"""


def failures(chapters: Iterable[Chapter]) -> list[str]:
    """The checks that are not met, written so that NaN is one of them."""
    return [
        f"{chapter.title}: {check.what}: found {check.found:g}, expected {check.expected:g}"
        for chapter in chapters
        for check in chapter.checks
        if not abs(check.error) <= check.bound
    ]


def main(argv: list[str] | None = None) -> int:
    """Compute, draw, write, and judge."""
    import validation_dynamics
    import validation_statics

    cases: dict[str, Callable[[Path], Chapter]] = validation_statics.CASES | (
        validation_dynamics.CASES
    )
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--output", type=Path, required=True, help="folder of validation.md")
    parser.add_argument("--cases", nargs="*", choices=cases, default=list(cases), metavar="CASE")
    options = parser.parse_args(argv)
    figures = options.output / "validation"
    figures.mkdir(parents=True, exist_ok=True)
    chapters = []
    for name in options.cases:
        print(f"{name} ...", file=sys.stderr, flush=True)
        chapters.append(cases[name](figures))
        print(chapters[-1].page(), end="\n\n", flush=True)
    if set(options.cases) == set(cases):
        page = "\n\n".join([HEAD.strip(), *(chapter.page() for chapter in chapters)])
        (options.output / "validation.md").write_text(page + "\n", encoding="utf-8")
    wrong = failures(chapters)
    for line in wrong:
        print(f"not met: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
