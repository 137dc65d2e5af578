"""The work of ``fenics-defo tradeoff``: measure, draw, print the choice."""

import json
import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fenics_defo.cli.command import Run
from fenics_defo.cli.kernels import no_unfinished_kernels
from fenics_defo.cli.output import libraries_on_stderr, write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.ranks import Ranks
from fenics_defo.cli.tradeoff_text import tradeoff_text
from fenics_defo.cli.watched import shown_phases
from fenics_defo.scene import Extent, Observer, read_scene, tradeoff
from fenics_defo.scene.trade.files import record
from fenics_defo.scene.trade.ladder import SMALL
from fenics_defo.view.trade_report import write_report

NONE_FITS = 3


def measure_and_print(options: Namespace, current: Run, progress: Progress, begin: float) -> None:
    """Do what the command line asks for.

    Args:
        options: of the command line.
        current: this run, to which the ranks are made known.
        progress: display and notes.
        begin: `time.perf_counter` when the command began [s].
    """
    current.ranks = ranks = Ranks()
    if not ranks.is_first:
        progress.silence()
    folder = Path(options.output)
    with libraries_on_stderr(), no_unfinished_kernels(), going_on(current, str(folder)):
        scene = ranks.on_first(lambda: read_scene(options.scene))
        observer = Observer(phases=shown_phases(current, progress, begin), moved=progress.move)
        extent = SMALL if options.small else Extent()
        found = tradeoff(scene, folder, extent=extent, refine=options.refine, observer=observer)
        progress.start("draw")
        files = write_report(found, folder)
    progress.stop()
    if found.choice is None:
        current.status = NONE_FITS
    if options.json:
        write_text(sys.stdout, json.dumps(record(found), allow_nan=False) + "\n")
    else:
        write_text(sys.stdout, tradeoff_text(found, str(folder), files))


@contextmanager
def going_on(current: Run, folder: str) -> Iterator[None]:
    """Say on Ctrl-C that nothing is lost.

    Args:
        current: this run.
        folder: that keeps what was measured.
    """
    try:
        yield
    except KeyboardInterrupt:
        current.stop(f"interrupted; {folder} keeps what is done, the same command goes on there")
