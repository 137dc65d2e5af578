"""What ``mesh-to-modes`` prints at the end: a table with a summary, or one JSON object."""

import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fenics_defo import __version__
from fenics_defo.cli.cell_names import CELL_NAMES
from fenics_defo.cli.materials import ChosenMaterials
from fenics_defo.cli.modes_table import table_lines
from fenics_defo.cli.number_text import six_digits
from fenics_defo.runtime import Modes


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesReport:
    """All that is told about a finished run.

    Args:
        mesh: name of the mesh file.
        modes: the modes.
        motions: word for the kind of motion of each mode.
        order: polynomial order of the displacements.
        dofs: number of displacement components, held ones included.
        fixed: the selections that are held.
        fixed_nodes: number of nodes held in at least one direction.
        materials: materials and where they come from.
        asked: number of modes asked for.
        why_unchecked: the option that left the inertia count out; empty if none did.
        notes: what reading the mesh changed or noticed, and the like.
        seconds: phase -> wall-clock time [s].
        files: names of the files written.
    """

    mesh: str
    modes: Modes
    motions: tuple[str, ...]
    order: int
    dofs: int
    fixed: tuple[str, ...]
    fixed_nodes: int
    materials: ChosenMaterials
    asked: int
    why_unchecked: str
    notes: tuple[str, ...]
    seconds: Mapping[str, float]
    files: tuple[str, ...]

    def text(self, *, style: bool = False) -> str:
        """Return the table and the summary.

        Args:
            style: use the escape codes of terminals.
        """
        lines = [*table_lines(self.modes, self.motions, style=style), "", *self._summary()]
        return "\n".join(lines) + "\n"

    def _summary(self) -> list[str]:
        modes = self.modes
        cells = f"{len(modes.cells)} {CELL_NAMES[modes.cell_type]}"
        return [
            f"mesh: {Path(self.mesh).name}, {cells}",
            f"dofs: {self.dofs}, displacements of order {self.order}",
            *self._material_lines(),
            f"mass: {modes.total_mass:.6g} kg",
            f"fixed: {self._fixed_text()}",
            f"modes: {self._modes_text()}",
            f"complete: {self._completeness()}",
            f"largest residual: {modes.residuals.max():.1e}",
            *self._seconds_lines(),
            f"written: {', '.join(self.files)}",
        ]

    def _material_lines(self) -> list[str]:
        lines = self.materials.lines()
        if len(lines) == 1:
            return [f"material: {self.materials.source}, {lines[0]}"]
        return [f"materials: {self.materials.source}", *(f"  {line}" for line in lines)]

    def _fixed_text(self) -> str:
        if not self.fixed:
            return "nothing, the body is free"
        return f"{self.fixed_nodes} of {len(self.modes.points)} nodes ({'; '.join(self.fixed)})"

    def _modes_text(self) -> str:
        text = f"{self.modes.size}, {self.modes.rigid_modes or 'none'} of them rigid"
        extra = self.modes.size - self.asked
        return text + (f"; {extra} more than asked keep equal frequencies together" * (extra > 0))

    def _seconds_lines(self) -> list[str]:
        phases = ", ".join(f"{n} {v:.2f}" for n, v in self.seconds.items() if v >= 0.005)
        text = f"seconds: {sum(self.seconds.values()):.2f} ({phases})"
        return textwrap.wrap(text, width=78, subsequent_indent="  ")

    def _completeness(self) -> str:
        modes = self.modes
        if modes.complete:
            last = six_digits(modes.frequencies[-1])
            return f"proved by an inertia count, no mode up to {last} Hz is missing"
        return f"not checked ({self.why_unchecked})" if self.why_unchecked else "not proved"

    def json_text(self) -> str:
        """Return one JSON object, on one line."""
        modes = self.modes
        record = {
            "frequencies_hz": modes.frequencies.tolist(),
            "residuals": modes.residuals.tolist(),
            "rigid_modes": modes.rigid_modes,
            "complete": modes.complete,
            "effective_mass": {
                name: column.tolist() for name, column in modes.effective_mass_by_direction.items()
            },
            "dofs": self.dofs,
            "cells": len(modes.cells),
            "seconds": dict(self.seconds),
            "mesh": self.mesh,
            "motion": list(self.motions),
            "nodes": len(modes.points),
            "order": self.order,
            "fixed": list(self.fixed),
            "fixed_nodes": self.fixed_nodes,
            "materials": self.materials.records(),
            "total_mass": modes.total_mass,
            "notes": list(self.notes),
            "files": list(self.files),
            "version": __version__,
        }
        return json.dumps(record, allow_nan=False) + "\n"
