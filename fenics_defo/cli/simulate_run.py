"""The work of ``fenics-defo simulate``: run the scene, show where it is, print the summary."""

import json
import sys
from argparse import Namespace
from typing import Any

from fenics_defo.cli.command import Run
from fenics_defo.cli.kernels import no_unfinished_kernels
from fenics_defo.cli.output import libraries_on_stderr, write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.ranks import Ranks
from fenics_defo.cli.simulate_report import summary_text
from fenics_defo.cli.watched import watched
from fenics_defo.scene import Cadence, read_scene, simulate


def simulate_and_print(options: Namespace, current: Run, progress: Progress, begin: float) -> None:
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
    with libraries_on_stderr(), no_unfinished_kernels():
        scene = ranks.on_first(lambda: read_scene(options.scene))
        record = _simulated(scene, options, current, progress, begin)
    progress.stop()
    if record["status"] == "interrupted":
        progress.tell_notes()
        current.stop(
            f"interrupted at {record['time']:.6g} s of {record['duration']:.6g} s; "
            f"{options.output} holds all until then, --restart goes on from there"
        )
    if ranks.is_first:
        text = json.dumps(record, allow_nan=False) + "\n" if options.json else summary_text(record)
        write_text(sys.stdout, text)


def _simulated(
    scene: Any, options: Namespace, current: Run, progress: Progress, begin: float
) -> dict[str, Any]:
    steps, seconds = options.checkpoint_every
    with watched(
        scene.time.duration,
        options.output,
        current=current,
        progress=progress,
        begin=begin,
        verb="simulate",
    ) as watcher:
        return simulate(
            scene,
            options.output,
            restart=options.restart,
            overwrite=options.overwrite,
            checkpoints=Cadence(steps=steps, seconds=seconds),
            watcher=watcher,
        )
