"""What ``summary.json`` says about a run."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo import __version__
from fenics_defo.analysis import Energies
from fenics_defo.scene.body import Body
from fenics_defo.scene.checkpoint import Tally
from fenics_defo.scene.records import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """How far a run is.

    Args:
        status: "running", "finished", "interrupted" or "failed".
        error: why it failed.
        time: reached [s].
        steps: done since time zero.
        begun_at: step that this process went on from.
        probes: displacement (3,) of each probe [m].
        energies: [J].
        energy_error: largest error of the energy balance over all energy put in [-]; None in
            statics.
        energy_gain: the same of what was gained [-].
        critical_step: largest stable step [s]; infinite for implicit methods.
        tally: what the run has added up.
        frames: number of frames.
        folder: name of the folder.
        files: names of the files written.
        seconds: phase -> time on the clock, of this process alone [s].
    """

    status: str
    error: str | None
    time: float
    steps: int
    begun_at: int
    probes: Sequence[NDArray[np.float64]]
    energies: Energies
    energy_error: float | None
    energy_gain: float | None
    critical_step: float
    tally: Tally
    frames: int
    folder: str
    files: Sequence[str]
    seconds: Mapping[str, float]


def summary_record(scene: Scene, body: Body, standing: Standing) -> dict[str, Any]:
    """A record ready for JSON.

    Args:
        scene: scene.
        body: its body.
        standing: how far its run is.
    """
    tally = standing.tally
    record: dict[str, Any] = {
        "status": standing.status,
        "time": standing.time,
        "duration": scene.time.duration,
        "steps": standing.steps,
        "steps_in_all": scene.time.steps,
        "steps_now": standing.steps - standing.begun_at,
        "step": scene.time.step,
        "integrator": scene.time.integrator,
        "linear_solver": body.solver,
        "scene": str(scene.path),
        "mesh": str(scene.mesh.file),
        "order": body.order,
        "nodes": len(body.points),
        "cells": len(body.cells),
        "dofs": body.dofs,
        "ranks": body.ranks,
        "probes": _probes(scene, standing),
        "energies": {
            name: _number(getattr(standing.energies, name))
            for name in ("kinetic", "strain", "external", "dissipated")
        },
        "energy_error": _number(standing.energy_error),
        "energy_gain": _number(standing.energy_gain),
        "newton_iterations": tally.newton_iterations,
        "linear_iterations": tally.linear_iterations,
        "halvings": tally.halvings,
        "critical_step": _number(standing.critical_step),
        "frames": standing.frames,
        "folder": standing.folder,
        "files": list(standing.files),
        "notes": list(body.notes),
        **body.more,
        "seconds": dict(standing.seconds),
        "version": __version__,
    }
    return record if standing.error is None else {**record, "error": standing.error}


def _probes(scene: Scene, standing: Standing) -> dict[str, Any]:
    items = zip(scene.probes, standing.probes, standing.tally.peaks, strict=True)
    return {
        probe.name: {
            "point": list(probe.point),
            "displacement": [_number(value) for value in displacement],
            "largest": _number(peak),
        }
        for probe, displacement, peak in items
    }


def _number(value: float | None) -> float | None:
    """The number for JSON, which has neither infinity nor NaN."""
    return float(value) if value is not None and math.isfinite(value) else None
