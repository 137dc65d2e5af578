"""When frames and checkpoints are due."""

from dataclasses import dataclass

from fenics_defo.scene.records import OutputTable, TimeTable

_FRAMES = 100  # about so many where the scene does not say


@dataclass(frozen=True, slots=True, kw_only=True)
class Cadence:
    """How often the state is saved that a run can go on from; the last state always is.

    Args:
        steps: after so many steps; None: not by steps.
        seconds: after so much time on the clock [s]; None: not by time.
    """

    steps: int | None = None
    seconds: float | None = 60.0


def is_frame(step: int, time: TimeTable, output: OutputTable) -> bool:
    """Whether a frame is due after that step."""
    if output.interval is not None:
        # The nearest whole number of intervals counts as reached: times are sums of steps.
        here, before = (n * time.step / output.interval + 1e-9 for n in (step, step - 1))
        return int(here) > int(before)
    every = output.every or max(1, time.steps // _FRAMES)
    return step % every == 0
