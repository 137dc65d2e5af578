"""What ``fenics-defo tradeoff`` understands."""

from typing import Any

from fenics_defo.cli.command import Parser

DESCRIPTION = """\
Measure which model a scene requires: the cheapest that is accurate and fast enough.

The scene is run with all of its body, then with a ladder of models: linear ones
by their exact filter and by steps, cubic (or Taylor) forces, cubature; of several
sizes, bases, steps and integrators. Each is held against the full run and timed.
What [require] asks for decides: tolerance, the largest error of displacements,
relative to the largest displacement (0.05 if not given); rate, steps a second;
outputs, the nodes that are looked at (all)."""

DETAILS = """\
DIR gets report.html, all of it on one page; tradeoff.png and errors.png, its
charts; tradeoff.json and tradeoff.csv, the table; model.npz, the model that was
chosen, with its certificate; and work, what has been measured: the same command
goes on where it was interrupted and measures nothing twice, as long as scene,
mesh and version stay the same. work may be deleted.

Examples
  fenics-defo tradeoff bar.toml --output trade
  fenics-defo play trade/model.npz bar.toml --output played

Exit status: 0 a model was chosen, 3 none fits (the nearest misses are told), 1
something to mend (one sentence says what), 130 interrupted."""


def add_tradeoff(commands: Any) -> None:
    """Add ``tradeoff`` to the parser's commands."""
    parser: Parser = commands.add_parser(
        "tradeoff",
        help="measure which model a scene requires, and make it",
        usage="fenics-defo tradeoff SCENE.toml --output DIR [options]",
        description=DESCRIPTION,
        epilog=DETAILS,
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "--output", required=True, metavar="DIR", help="folder of the results, made if missing"
    )
    parser.add_argument(
        "--refine",
        action="store_true",
        help="estimate the mesh's error too, by a run of second order",
    )
    parser.add_argument(
        "--small", action="store_true", help="the few candidates that reduce looks at"
    )
    parser.add_argument("--json", action="store_true", help="print tradeoff.json instead")
