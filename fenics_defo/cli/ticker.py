"""The progress display, a process of its own: PETSc's long calls stop all threads of Python.

Reads lines from standard input, ``phase NAME``, ``at FRACTION TEXT`` and ``note TEXT``, shows the
phase with a spinner and its time on standard error, with a bar and the time left once a fraction
has come, and takes all away at the end of its input. While PETSc computes,
Ctrl-C reaches the computation only when the call returns: this process says so, and ends the
computation at once when Ctrl-C comes again.
"""

import os
import signal
import sys
from types import FrameType

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

STOPPING = "stopping when this step is done (Ctrl-C again: at once)"


def main() -> None:
    """Show what comes in until it ends."""
    parent = os.getppid()
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    bar = BarColumn(), TaskProgressColumn(), TextColumn("left"), TimeRemainingColumn()
    console = Console(stderr=True, highlight=False)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("", total=None)
        interrupts = 0

        def interrupted(_number: int, _frame: FrameType | None) -> None:
            nonlocal interrupts
            interrupts += 1
            if interrupts > 1 and os.getppid() == parent:
                os.kill(parent, signal.SIGKILL)
            progress.update(task, description=STOPPING)

        signal.signal(signal.SIGINT, interrupted)
        for line in sys.stdin:
            kind, _, text = line.rstrip("\n").partition(" ")
            if kind == "note":
                progress.console.print(f"note: {text}", markup=False, soft_wrap=True)
            elif interrupts:
                continue
            elif kind == "at":
                fraction, _, text = text.partition(" ")
                progress.columns = (*columns, *bar)
                progress.update(task, total=1.0, completed=float(fraction), description=text)
            else:
                progress.columns = columns
                progress.tasks[0].total = None  # which reset() would keep
                progress.reset(task, description=text)


if __name__ == "__main__":
    main()
