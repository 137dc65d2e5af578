"""How a scene's loads and prescribed motions vary in time."""

from fenics_defo.analysis.histories import History, Pulse, Ramp, Sine, Step, Table
from fenics_defo.scene.records import HistoryTable, TimeTable


def load_factor(history: HistoryTable | None, time: TimeTable) -> History:
    """The factor in time; what is not given is 1, in statics t / duration."""
    if history is None:
        return Ramp(time.duration) if time.is_static else Step(start=-time.duration)
    match history.kind:
        case "ramp":
            return Ramp(history.duration, history.start)
        case "sine":
            return Sine(history.frequency, history.phase)
        case "pulse":
            return Pulse(history.start, history.duration)
        case "table":
            return Table(history.times, history.values)
    return Step(history.start)
