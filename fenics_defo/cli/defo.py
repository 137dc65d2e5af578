"""``fenics-defo``: scenes simulated, and what files of ours hold."""

import sys
import time
from argparse import Namespace

from fenics_defo import __version__
from fenics_defo.cli.command import Parser, Run, number, run
from fenics_defo.cli.simulate_options import add_simulate


def build_parser() -> Parser:
    """Return the parser of the command line."""
    parser = Parser(prog="fenics-defo", description="Deformable solids: simulation, files.")
    parser.add_argument("--version", action="version", version=f"fenics_defo {__version__}")
    commands = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    add_simulate(commands)
    what = "what a mesh, a file of modes, a scene or a folder of results holds"
    info = commands.add_parser(
        "info",
        help=what,
        description=f"Tell {what}.\n\n"
        "Of a mesh: nodes, cells, size, volume, groups, materials, pieces, quality of the\n"
        "cells, and what reading changed or noticed. Of modes: their table. Of a scene: what it\n"
        "asks for. Of a folder of results: its summary.",
        epilog="Examples\n  fenics-defo info bracket.step --size 0.004\n"
        "  fenics-defo info modes.npz --json",
    )
    info.add_argument("file", metavar="FILE", help="mesh, modes.npz, scene, or folder of results")
    info.add_argument(
        "--size",
        type=number,
        metavar="H",
        help="edge length [m] of the tetrahedra that fill a surface or a CAD solid",
    )
    info.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def main(argv: list[str] | None = None) -> int:
    """Run the command and return its exit status.

    Args:
        argv: arguments; those of the process if not given.
    """
    try:
        options = build_parser().parse_args(argv)
    except SystemExit as leaving:  # --help, --version, or an error already told
        return int(leaving.code or 0)
    begin = time.perf_counter()
    if options.command == "simulate":
        return run("fenics-defo", lambda current: _simulate(options, current, begin))
    return run("fenics-defo", lambda current: _tell_content(options, current))


def _simulate(options: Namespace, current: Run, begin: float) -> None:
    # Late imports, as below.
    from fenics_defo.cli.output import libraries_on_stderr, loading_libraries
    from fenics_defo.cli.progress import progress_shown

    with progress_shown(show=current.is_first) as progress:
        progress.start("load")
        with libraries_on_stderr(), loading_libraries():
            from fenics_defo.cli.simulate_run import simulate_and_print
        simulate_and_print(options, current, progress, begin)


def _tell_content(options: Namespace, current: Run) -> None:
    if not current.is_first:  # started by mpiexec: nothing here needs several processes
        return
    # Late imports: they load NumPy and, for a mesh, DOLFINx and its company.
    from fenics_defo.cli.progress import progress_shown

    with progress_shown(show=not options.json) as progress:
        progress.start("read")
        from fenics_defo.cli.info import print_info

        print_info(options.file, size=options.size, as_json=options.json, progress=progress)


if __name__ == "__main__":
    sys.exit(main())
