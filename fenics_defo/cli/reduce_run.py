"""The work of ``fenics-defo reduce``: make the model, write it, say what it holds."""

import json
import sys
from argparse import Namespace

from fenics_defo.cli.command import Run
from fenics_defo.cli.kernels import no_unfinished_kernels
from fenics_defo.cli.model_info import model_record, model_text
from fenics_defo.cli.output import libraries_on_stderr, write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.ranks import Ranks
from fenics_defo.cli.watched import shown_phases
from fenics_defo.scene import Recipe, Watcher, read_scene, reduce_scene


def reduce_and_print(options: Namespace, current: Run, progress: Progress, begin: float) -> None:
    """Do what the command line asks for; collective.

    Args:
        options: of the command line.
        current: this run, to which the ranks are made known.
        progress: display and notes.
        begin: `time.perf_counter` when the command began [s].
    """
    current.ranks = ranks = Ranks()
    if not ranks.is_first:
        progress.silence()
    phases = shown_phases(current, progress, begin)
    kind, snapshots = options.basis or (None, None)
    with libraries_on_stderr(), no_unfinished_kernels():
        scene = ranks.on_first(lambda: read_scene(options.scene))
        recipe = Recipe(
            basis=kind,
            snapshots=snapshots,
            modes=options.modes,
            size=options.size,
            share=options.share,
            force=options.force,
            tolerance=options.tolerance,
        )
        model = reduce_scene(scene, options.output, recipe=recipe, watcher=Watcher(phases=phases))
    progress.stop()
    if ranks.is_first:
        record = {**model_record(options.output, model), "seconds": dict(phases.seconds)}
        text = json.dumps(record, allow_nan=False) + "\n" if options.json else model_text(record)
        write_text(sys.stdout, text)
