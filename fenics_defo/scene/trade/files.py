"""A trade-off as files: all of it as JSON, the table for spreadsheets."""

import csv
import io
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fenics_defo.runtime import atomic_path
from fenics_defo.scene.trade.records import Measurement, Tradeoff

JSON, CSV = "tradeoff.json", "tradeoff.csv"

_COLUMNS = (
    "error",
    "error_rms",
    "error_whole",
    "best_error",
    "energy_error",
    "frequency",
    "frequency_error",
    "microseconds",
    "microseconds_p99",
    "cost",
    "real_time",
    "offline_seconds",
    "model_bytes",
    "batch",
    "batch_rate",
)


def write_tables(found: Tradeoff, folder: Path) -> None:
    """Write ``tradeoff.json`` and ``tradeoff.csv``.

    Args:
        found: the trade-off.
        folder: that they go to.
    """
    _write(folder / JSON, json.dumps(record(found), indent=1, allow_nan=False) + "\n")
    _write(folder / CSV, _table(found))


def record(found: Tradeoff) -> dict[str, Any]:
    """A trade-off ready for JSON."""
    plain = _plain(asdict(found))
    for row, measurement in zip(plain["rows"], found.rows, strict=True):
        row["name"], row["cost"] = measurement.candidate.name, _plain(measurement.cost)
    chosen = None if found.choice is None else plain["rows"][found.choice]
    return {**plain, "chosen": chosen}


def _table(found: Tradeoff) -> str:
    probes = sorted({name for row in found.rows for name in row.probe_errors})
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    spec = ("basis", "force", "size", "cubature_tolerance")
    head = ("name", "kind", *spec, "law", "integrator", "step", "status", "chosen", "front")
    table.writerow([*head, *_COLUMNS, *(f"error_{name}" for name in probes), "reason"])
    for number, row in enumerate(found.rows):
        table.writerow(
            [
                *_about(row),
                int(number == found.choice),
                int(number in found.front),
                *(_cell(getattr(row, name)) for name in _COLUMNS),
                *(_cell(row.probe_errors.get(name)) for name in probes),
                row.reason,
            ]
        )
    return text.getvalue()


def _about(row: Measurement) -> list[Any]:
    candidate, model = row.candidate, row.candidate.model
    spec: list[Any] = [""] * 4
    if model is not None:
        spec = [model.basis, model.force, model.size, _cell(model.tolerance)]
    method = [candidate.law, candidate.integrator, repr(candidate.step)]
    return [candidate.name, candidate.kind, *spec, *method, row.status]


def _cell(value: float | int | None) -> str:
    return "" if value is None else repr(value)


def _plain(value: Any) -> Any:
    """Values that JSON has: neither infinity nor NaN."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _write(path: Path, text: str) -> None:
    with atomic_path(path) as name:
        name.write_text(text, "utf-8")
