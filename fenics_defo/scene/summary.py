"""What ``summary.json`` says about a run."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo import __version__
from fenics_defo.analysis import Energies, Simulation
from fenics_defo.fem import Solid
from fenics_defo.scene.checkpoint import Tally
from fenics_defo.scene.records import Scene


def summary_record(
    scene: Scene,
    solid: Solid,
    simulation: Simulation,
    *,
    status: str,
    error: str | None,
    probes: Sequence[NDArray[np.float64]],
    energies: Energies,
    critical_step: float,
    tally: Tally,
    begun_at: int,
    frames: int,
    folder: str,
    files: Sequence[str],
    seconds: Mapping[str, float],
) -> dict[str, Any]:
    """A record ready for JSON.

    Args:
        scene: scene.
        solid: its body.
        simulation: its simulation.
        status: "running", "finished", "interrupted" or "failed".
        error: why it failed.
        probes: displacement (3,) of each probe now [m].
        energies: now [J].
        critical_step: largest stable step [s]; infinite for implicit methods.
        tally: what the run has added up.
        begun_at: step that this process went on from.
        frames: number of frames.
        folder: name of the folder.
        files: names of the files written.
        seconds: phase -> time on the clock, of this process alone [s].
    """
    record: dict[str, Any] = {
        "status": status,
        "time": simulation.time,
        "duration": scene.time.duration,
        "steps": simulation.steps,
        "steps_in_all": scene.time.steps,
        "steps_now": simulation.steps - begun_at,
        "step": scene.time.step,
        "integrator": scene.time.integrator,
        "linear_solver": scene.solver.linear,
        "scene": str(scene.path),
        "mesh": str(scene.mesh.file),
        "order": solid.order,
        "nodes": len(solid.points),
        "cells": len(solid.cells),
        "dofs": solid.dof_count,
        "ranks": solid.comm.size,
        "probes": {
            probe.name: {
                "point": list(probe.point),
                "displacement": [_number(value) for value in displacement],
                "largest": _number(peak),
            }
            for probe, displacement, peak in zip(scene.probes, probes, tally.peaks, strict=True)
        },
        "energies": {
            "kinetic": _number(energies.kinetic),
            "strain": _number(energies.strain),
            "external": _number(energies.external),
            "dissipated": _number(energies.dissipated),
        },
        "newton_iterations": tally.newton_iterations,
        "linear_iterations": tally.linear_iterations,
        "halvings": tally.halvings,
        "critical_step": _number(critical_step),
        "frames": frames,
        "folder": folder,
        "files": list(files),
        "notes": list(solid.record.notes),
        "seconds": dict(seconds),
        "version": __version__,
    }
    if error is not None:
        record["error"] = error
    return record


def _number(value: float) -> float | None:
    """The number for JSON, which has neither infinity nor NaN."""
    return float(value) if math.isfinite(value) else None
