"""What ``fenics-defo simulate`` and ``play`` print at the end of a run."""

import textwrap
from collections.abc import Mapping
from typing import Any

from fenics_defo.cli.number_text import short_number


def summary_text(record: Mapping[str, Any]) -> str:
    """Write the content of ``summary.json`` for people."""
    seconds = record["seconds"]
    pace = 1e3 * seconds.get("step", seconds.get("simulate", 0.0)) / max(1, record["steps_now"])
    lines = [
        f"{'played' if 'model' in record else 'simulated'}: {record['time']:.6g} s in "
        f"{record['steps']} steps of {record['step']:.6g} s, {record['integrator']}"
        f"{_status(record)}",
        f"mesh: {record['mesh']}, {record['cells']} cells, {record['nodes']} nodes",
        f"dofs: {record['dofs']}, displacements of order {record['order']}, "
        f"solver {record['linear_solver']}",
        *_model_lines(record),
        *_probe_lines(record["probes"]),
        "energies: "
        + ", ".join(f"{name} {short_number(v)} J" for name, v in record["energies"].items()),
        f"pace: {pace:.3g} ms a step, {record['newton_iterations']} Newton iterations, "
        f"{record['halvings']} halved steps{_real_time(record)}",
        *_seconds_lines(record["seconds"]),
        f"written: {', '.join(record['files'])} in {record['folder']}",
    ]
    return "\n".join(lines) + "\n"


def _status(record: Mapping[str, Any]) -> str:
    """What there is to say of a run that has not come to its end."""
    if record["status"] == "finished":
        return ""
    return f"; {record['status']}, of {record['duration']:.6g} s"


def _model_lines(record: Mapping[str, Any]) -> list[str]:
    if "model" not in record:
        return []
    return [f"model: {record['model']}, r = {record['dofs']}, {record['force']} forces"]


def _real_time(record: Mapping[str, Any]) -> str:
    """How much faster than the clock a model ran."""
    spent = record["seconds"].get("step", 0.0)
    if not spent > 0.0 or record["integrator"] == "static":
        return ""
    return f", {short_number(float(f'{record["time"] / spent:.3g}'))} times real time"


def _probe_lines(probes: Mapping[str, Any]) -> list[str]:
    return [
        f"probe {name}: at ({', '.join(map(short_number, probe['displacement']))}) m, "
        f"at most {short_number(probe['largest'])} m from rest"
        for name, probe in probes.items()
    ]


def _seconds_lines(seconds: Mapping[str, float]) -> list[str]:
    phases = ", ".join(f"{name} {value:.2f}" for name, value in seconds.items() if value >= 0.005)
    text = f"seconds: {sum(seconds.values()):.2f} ({phases})"
    return textwrap.wrap(text, width=78, subsequent_indent="  ")
