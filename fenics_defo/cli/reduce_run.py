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
from fenics_defo.cli.tradeoff_text import choice_lines
from fenics_defo.cli.watched import shown_phases
from fenics_defo.runtime import load
from fenics_defo.scene import (
    Observer,
    Recipe,
    Tradeoff,
    Watcher,
    choose_model,
    is_required,
    read_scene,
    reduce_scene,
)
from fenics_defo.scene.trade.files import record as trade_record

NONE_FITS = 3


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
    with libraries_on_stderr(), no_unfinished_kernels():
        scene = ranks.on_first(lambda: read_scene(options.scene))
        # Times are measured by one process alone.
        if is_required(scene) and not ranks.are_many and not _has_options(options):
            observer = Observer(phases=phases, moved=progress.move)
            found = choose_model(scene, options.output, observer=observer)
        else:
            found = None
            model = reduce_scene(
                scene, options.output, recipe=_recipe(options), watcher=Watcher(phases=phases)
            )
    progress.stop()
    if found is not None:
        _tell_choice(found, options, current, progress, dict(phases.seconds))
    elif ranks.is_first:
        record = {**model_record(options.output, model), "seconds": dict(phases.seconds)}
        text = json.dumps(record, allow_nan=False) + "\n" if options.json else model_text(record)
        write_text(sys.stdout, text)


def _recipe(options: Namespace) -> Recipe:
    kind, snapshots = options.basis or (None, None)
    return Recipe(
        basis=kind,
        snapshots=snapshots,
        modes=options.modes,
        size=options.size,
        share=options.share,
        force=options.force,
        **({} if options.tolerance is None else {"tolerance": options.tolerance}),
    )


def _has_options(options: Namespace) -> bool:
    """Whether the command line says how the model is to be made."""
    names = ("basis", "modes", "size", "share", "force", "tolerance")
    return any(getattr(options, name) is not None for name in names)


def _tell_choice(
    found: Tradeoff,
    options: Namespace,
    current: Run,
    progress: Progress,
    seconds: dict[str, float],
) -> None:
    """Print what was chosen of what was measured, or why nothing was."""
    if found.choice is None:
        current.status = NONE_FITS
        progress.tell_notes()
        record = trade_record(found)
        text = "".join(f"{line}\n" for line in choice_lines(found))
    else:
        model = load(options.output)
        record = {**model_record(options.output, model), "seconds": seconds}
        text = model_text(record) + "".join(f"{line}\n" for line in choice_lines(found))
    write_text(sys.stdout, json.dumps(record, allow_nan=False) + "\n" if options.json else text)
