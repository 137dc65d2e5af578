"""``fenics-defo``: scenes simulated, reduced, played and measured, and what files hold."""

import sys
import time
from argparse import Namespace
from collections.abc import Callable

from fenics_defo import __version__
from fenics_defo.cli.command import Parser, Run, number, run
from fenics_defo.cli.reduce_options import add_play, add_reduce
from fenics_defo.cli.simulate_options import add_simulate
from fenics_defo.cli.tradeoff_options import add_tradeoff

type Work = Callable[[Namespace, Run, float], None]


def build_parser() -> Parser:
    """Return the parser of the command line."""
    parser = Parser(prog="fenics-defo", description="Deformable solids: simulation, models, files.")
    parser.add_argument("--version", action="version", version=f"fenics_defo {__version__}")
    commands = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    add_simulate(commands)
    add_reduce(commands)
    add_play(commands)
    add_tradeoff(commands)
    what = "what a mesh, a file of modes, a model, a scene or a folder of results holds"
    info = commands.add_parser(
        "info",
        help=what,
        description=f"Tell {what}.\n\n"
        "Of a mesh: nodes, cells, size, volume, groups, materials, pieces, quality of the\n"
        "cells, and what reading changed or noticed. Of modes: their table. Of a model: its size,\n"
        "forces, and what it was made from. Of a scene: what it asks for. Of a folder of\n"
        "results: its summary.",
        epilog="Examples\n  fenics-defo info bracket.step --size 0.004\n"
        "  fenics-defo info modes.npz --json",
    )
    info.add_argument("file", metavar="FILE", help="mesh, modes, model, scene, or folder")
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
    work: dict[str, Work] = {
        "simulate": _with_fenicsx(_simulate),
        "reduce": _with_fenicsx(_reduce),
        "play": _play,
        "tradeoff": _with_fenicsx(_tradeoff),
        "info": _tell_content,
    }
    return run("fenics-defo", lambda current: work[options.command](options, current, begin))


def _with_fenicsx(load: Callable[[], Callable[..., None]]) -> Work:
    """The work of a command that needs FEniCSx, which ``load`` imports when there is work."""

    def do(options: Namespace, current: Run, begin: float) -> None:
        from fenics_defo.cli.output import libraries_on_stderr, loading_libraries
        from fenics_defo.cli.progress import progress_shown

        with progress_shown(show=current.is_first) as progress:
            progress.start("load")
            with libraries_on_stderr(), loading_libraries():
                work = load()
            work(options, current, progress, begin)

    return do


def _simulate() -> Callable[..., None]:
    from fenics_defo.cli.simulate_run import simulate_and_print

    return simulate_and_print


def _reduce() -> Callable[..., None]:
    from fenics_defo.cli.reduce_run import reduce_and_print

    return reduce_and_print


def _tradeoff() -> Callable[..., None]:
    from fenics_defo.cli.tradeoff_run import measure_and_print

    return measure_and_print


def _play(options: Namespace, current: Run, begin: float) -> None:
    if not current.is_first:  # started by mpiexec: a model needs one process
        return
    from fenics_defo.cli.progress import progress_shown

    with progress_shown(show=True) as progress:
        progress.start("load")
        from fenics_defo.cli.play_run import play_and_print  # NumPy and nothing else

        play_and_print(options, current, progress, begin)


def _tell_content(options: Namespace, current: Run, _begin: float) -> None:
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
