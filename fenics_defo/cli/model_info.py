"""What a reduced model's file holds."""

import os
import textwrap
from collections.abc import Mapping
from typing import Any

from fenics_defo.cli.number_text import short_number, six_digits
from fenics_defo.runtime import ReducedModel

_WIDTH = 78


def model_record(file: str, model: ReducedModel) -> dict[str, Any]:
    """Return what there is to know, ready for JSON.

    Args:
        file: name of the model's file.
        model: what it holds.
    """
    return {
        "kind": "model",
        "file": file,
        "bytes": os.stat(file).st_size,
        "size": model.size,
        "force": model.law.kind,
        "frequencies_hz": model.frequencies.tolist(),
        "damping": list(model.damping),
        "floating": model.frame is not None,
        "nodes": len(model.nodes),
        "cells": len(model.outputs.cells) if model.outputs.cells is not None else 0,
        "probes": {name: probe.point.tolist() for name, probe in model.probes.items()},
        "loads": list(model.loads),
        "provenance": dict(model.provenance),
        "certificate": dict(model.certificate),
    }


def model_text(record: Mapping[str, Any]) -> str:
    """Write the record of `model_record` for people."""
    frequencies = record["frequencies_hz"]
    alpha, beta = record["damping"]
    origin = record["provenance"].get("scene")
    lines = [
        f"file: {record['file']}, a reduced model of {record['bytes'] / 1e3:.4g} kB",
        f"model: r = {record['size']} coordinates, {record['force']} forces"
        + (", free to fly" if record["floating"] else ""),
        f"frequencies at rest: {six_digits(frequencies[0])} to {six_digits(frequencies[-1])} Hz",
        f"damping: {short_number(alpha)} 1/s of the mass, {short_number(beta)} s of the stiffness",
        f"stored: {record['nodes']} nodes, {record['cells']} cells",
        *_listed("probes", list(record["probes"])),
        *_listed("loads", ["gravity", *_places(record["loads"])]),
    ]
    if isinstance(origin, dict):
        lines.append(
            f"scene: {origin.get('file')}, mesh {origin.get('mesh file')}, {origin.get('dofs')} "
            f"dofs, displacements of order {origin.get('order')}"
        )
    lines += [line for name in ("provenance", "certificate") for line in _values(record, name)]
    if "seconds" in record:
        seconds = {name: value for name, value in record["seconds"].items() if value >= 0.005}
        told = ", ".join(f"{name} {value:.2f}" for name, value in seconds.items())
        lines.append(f"seconds: {sum(record['seconds'].values()):.2f} ({told})")
    return "\n".join(lines) + "\n"


def _places(loads: list[str]) -> list[str]:
    """What acts where; not along which axis, and not what initial states are made of."""
    names = [name.partition(" along ")[0] for name in loads if not name.startswith("mass times")]
    return list(dict.fromkeys(names))


def _listed(name: str, values: list[str]) -> list[str]:
    text = f"{name}: {', '.join(values) or 'none'}"
    return textwrap.wrap(text, _WIDTH, subsequent_indent="  ", break_long_words=False)


def _values(record: Mapping[str, Any], name: str) -> list[str]:
    """A line for the plain values of a mapping."""
    plain = {k: v for k, v in record[name].items() if isinstance(v, str | int | float)}
    return _listed(name, [f"{key} {value}" for key, value in plain.items()]) if plain else []
