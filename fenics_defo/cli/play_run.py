"""The work of ``fenics-defo play``: run the model, show where it is, print the summary."""

import json
import sys
from argparse import Namespace

from fenics_defo.cli.command import Run
from fenics_defo.cli.output import write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.simulate_report import summary_text
from fenics_defo.cli.watched import watched
from fenics_defo.scene.parsing import parse_scene
from fenics_defo.scene.playing import play


def play_and_print(options: Namespace, current: Run, progress: Progress, begin: float) -> None:
    """Do what the command line asks for; needs NumPy only.

    Args:
        options: of the command line.
        current: this run.
        progress: display and notes.
        begin: `time.perf_counter` when the command began [s].
    """
    scene = parse_scene(options.scene)
    with watched(
        scene.time.duration,
        options.output,
        current=current,
        progress=progress,
        begin=begin,
        verb="play",
    ) as watcher:
        record = play(
            options.model, scene, options.output, overwrite=options.overwrite, watcher=watcher
        )
    progress.stop()
    if record["status"] == "interrupted":
        progress.tell_notes()
        current.stop(
            f"interrupted at {record['time']:.6g} s of {record['duration']:.6g} s; "
            f"{options.output} holds all until then"
        )
    text = json.dumps(record, allow_nan=False) + "\n" if options.json else summary_text(record)
    write_text(sys.stdout, text)
