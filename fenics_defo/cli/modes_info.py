"""What a file of modes holds."""

from typing import Any

import numpy as np

from fenics_defo.analysis import describe_motion
from fenics_defo.cli.cell_names import CELL_NAMES
from fenics_defo.cli.modes_table import table_lines
from fenics_defo.cli.number_text import six_digits
from fenics_defo.runtime import Modes


def modes_record(file: str, modes: Modes) -> dict[str, Any]:
    """Return what there is to know, ready for JSON."""
    return {
        "kind": "modes",
        "file": file,
        "frequencies_hz": modes.frequencies.tolist(),
        "residuals": modes.residuals.tolist(),
        "rigid_modes": modes.rigid_modes,
        "complete": modes.complete,
        "effective_mass": {
            name: column.tolist() for name, column in modes.effective_mass_by_direction.items()
        },
        "motion": list(describe_motion(modes)),
        "nodes": len(modes.points),
        "cells": len(modes.cells),
        "cell_type": modes.cell_type,
        "total_mass": modes.total_mass,
        "centre": modes.centre.tolist(),
        "bounding_box": [modes.points.min(axis=0).tolist(), modes.points.max(axis=0).tolist()],
    }


def modes_text(file: str, modes: Modes, *, style: bool = False) -> str:
    """Return the table of the modes and a summary.

    Args:
        file: name of the file.
        modes: what it holds.
        style: use the escape codes of terminals.
    """
    proved = f"proved up to {six_digits(modes.frequencies[-1])} Hz by an inertia count"
    size = float(np.ptp(modes.points, axis=0).max())
    centre = ", ".join(
        f"{value:.6g}" if abs(value) > 1e-9 * size else "0" for value in modes.centre
    )
    lines = [
        *table_lines(modes, describe_motion(modes), style=style),
        "",
        f"file: {file}, vibration modes",
        f"mesh: {len(modes.cells)} {CELL_NAMES[modes.cell_type]}, {len(modes.points)} nodes",
        f"mass: {modes.total_mass:.6g} kg, centre at ({centre}) m",
        f"modes: {modes.size}, {modes.rigid_modes or 'none'} of them rigid",
        f"complete: {proved if modes.complete else 'not proved'}",
        f"largest residual: {modes.residuals.max():.1e}",
    ]
    return "\n".join(lines) + "\n"
