"""Vibration modes as plain arrays: the record and its file."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.archive import ArraySpec, read_archive, write_archive

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""Columns of `Modes.participation`: translations along and rotations about the axes."""

NODES_PER_CELL = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron27": 27}
"""Cell types by their meshio names; the nodes of a cell are in the order of VTK."""

_KIND = "modes"
_VERSION = 1
_UNITS = {
    "frequencies": "Hz",
    "shapes": "kg^-1/2",
    "points": "m",
    "node_mass": "kg",
    "residuals": "1",
    "participation": "kg^1/2 (x, y, z), kg^1/2 m (rx, ry, rz)",
    "total_mass": "kg",
    "centre": "m",
    "inertia": "kg (x, y, z), kg m^2 (rx, ry, rz)",
}
_ARRAYS = {
    "frequencies": ArraySpec("f", 1),
    "shapes": ArraySpec("f", 3),
    "points": ArraySpec("f", 2),
    "cells": ArraySpec("iu", 2),
    "cell_type": ArraySpec("U", 0),
    "node_numbers": ArraySpec("iu", 1),
    "node_mass": ArraySpec("f", 1),
    "residuals": ArraySpec("f", 1),
    "rigid_modes": ArraySpec("iu", 0),
    "complete": ArraySpec("b", 0),
    "participation": ArraySpec("f", 2),
    "total_mass": ArraySpec("f", 0),
    "centre": ArraySpec("f", 1),
    "inertia": ArraySpec("f", 1),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Modes:
    """Lowest k undamped vibration modes of a body of n nodes and m cells.

    They solve K phi = omega^2 M phi with phi_i^T M phi_j = 1 if i = j else 0. Nodes and cells are
    in the order of the user's file. The arrays are kept as read-only views, not copied.

    Args:
        frequencies: omega / (2 pi) (k,) [Hz], not negative, ascending.
        shapes: mass-normalised displacements phi (k, n, 3) [kg^-1/2].
        points: nodes at rest (n, 3) [m].
        cells: node indices, zero-based (m, c), int64, in the node order of VTK.
        cell_type: a key of `NODES_PER_CELL`.
        node_numbers: number of each node in the user's file (n,), int64; 0 for a node that a
            second-order approximation appended.
        node_mass: lumped mass of each node (n,) [kg], not negative.
        residuals: |K phi - omega^2 M phi| relative to the solver's scale (k,) [-].
        rigid_modes: how many modes, from the first, are rigid motions; 0 when they were left
            out or the body is held.
        complete: whether an inertia count proved that no mode is missing below the last.
        participation: Gamma = phi^T M r (k, 6) [kg^1/2, kg^1/2 m], with r the unit rigid motion
            of each of `DIRECTIONS`, rotations about ``centre``.
        total_mass: mass of the body [kg].
        centre: centre of mass (3,) [m].
        inertia: r^T M r for each of `DIRECTIONS` (6,) [kg, kg m^2].

    Raises:
        ValueError: arrays whose shapes or values do not fit together.
    """

    frequencies: Array
    shapes: Array
    points: Array
    cells: IntArray
    cell_type: str
    node_numbers: IntArray
    node_mass: Array
    residuals: Array
    rigid_modes: int
    complete: bool
    participation: Array
    total_mass: float
    centre: Array
    inertia: Array

    def __post_init__(self) -> None:
        k = np.shape(self.frequencies)[0] if np.ndim(self.frequencies) == 1 else -1
        n = np.shape(self.points)[0] if np.ndim(self.points) == 2 else -1
        shapes = {"frequencies": (k,), "shapes": (k, n, 3), "points": (n, 3), "residuals": (k,)}
        shapes |= {"node_mass": (n,), "participation": (k, 6), "centre": (3,), "inertia": (6,)}
        for name, shape in shapes.items():
            self._freeze(name, np.float64, shape)
        if self.cell_type not in NODES_PER_CELL:
            raise ValueError(f"cell_type {self.cell_type!r} is not one of {list(NODES_PER_CELL)}")
        width = NODES_PER_CELL[self.cell_type]
        m = np.shape(self.cells)[0] if np.ndim(self.cells) == 2 else -1
        self._freeze("cells", np.int64, (m, width))
        self._freeze("node_numbers", np.int64, (n,))
        object.__setattr__(self, "rigid_modes", int(self.rigid_modes))
        object.__setattr__(self, "complete", bool(self.complete))
        object.__setattr__(self, "total_mass", float(self.total_mass))
        self._check_values()

    def _freeze(self, name: str, dtype: type, shape: tuple[int, ...]) -> None:
        """Keep a read-only contiguous view of an array, if its shape and values allow."""
        given = np.asarray(getattr(self, name))
        if given.shape != shape or min(shape) < 0:
            raise ValueError(f"{name} has the shape {given.shape}, which does not fit {shape}")
        if not np.can_cast(given.dtype, dtype, "same_kind"):
            raise ValueError(f"{name} has the type {given.dtype}, expected {np.dtype(dtype)}")
        array: NDArray[Any] = np.ascontiguousarray(given, dtype=dtype).view()
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds values that are not finite")
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    def _check_values(self) -> None:
        f = self.frequencies
        if not ((f >= 0.0).all() and (np.diff(f) >= 0.0).all()):
            raise ValueError("frequencies must ascend and not be negative")
        if not 0 <= self.rigid_modes <= f.size:
            raise ValueError(f"rigid_modes = {self.rigid_modes} is not between 0 and {f.size}")
        if self.cells.size and not 0 <= self.cells.min() <= self.cells.max() < len(self.points):
            raise ValueError(f"cells name nodes outside 0 to {len(self.points) - 1}")
        if not (self.node_numbers >= 0).all():
            raise ValueError("node_numbers must not be negative")
        if not (self.node_mass >= 0.0).all():
            raise ValueError("node_mass must not be negative; scale the diagonal to lump it")
        if not (0.0 < self.total_mass < np.inf and (self.inertia > 0.0).all()):
            raise ValueError("total_mass and inertia must be positive and finite")

    @property
    def size(self) -> int:
        """Number of modes k."""
        return self.frequencies.size

    @property
    def omega(self) -> Array:
        """Angular frequencies (k,) [rad/s]."""
        return 2.0 * np.pi * self.frequencies

    @property
    def periods(self) -> Array:
        """Periods 1 / f (k,) [s]; infinite where the frequency is 0."""
        f = self.frequencies
        return np.divide(1.0, f, out=np.full_like(f, np.inf), where=f > 0.0)

    @property
    def effective_mass(self) -> Array:
        """Effective masses Gamma^2 / (r^T M r) (k, 6) [-]: fractions of ``inertia``.

        Over all modes of an unconstrained discrete body each column sums to 1.
        """
        return self.participation**2 / self.inertia

    @property
    def cumulative_effective_mass(self) -> Array:
        """Sums of `effective_mass` up to and including each mode (k, 6) [-]."""
        return np.cumsum(self.effective_mass, axis=0)

    @property
    def effective_mass_by_direction(self) -> dict[str, Array]:
        """Columns of `effective_mass` by the names in `DIRECTIONS`."""
        return dict(zip(DIRECTIONS, self.effective_mass.T, strict=True))

    def select(self, indices: Sequence[int] | IntArray | slice) -> Self:
        """Return some of the modes, in ascending order.

        Args:
            indices: zero-based modes without repetition (negative ones count from the end), a
                slice, or a mask (k,) of booleans.

        Returns:
            the same body with those modes. It stays ``complete`` only without gaps from the
            first mode on.

        Raises:
            ValueError: a mode is named twice, or indices are not integers.
            IndexError: a mode does not exist.
        """
        chosen = np.sort(np.arange(self.size)[indices])
        if chosen.ndim != 1 or np.unique(chosen).size < chosen.size:
            raise ValueError(f"indices must name each mode once, got {indices!r}")
        return replace(
            self,
            frequencies=self.frequencies[chosen],
            shapes=self.shapes[chosen],
            residuals=self.residuals[chosen],
            participation=self.participation[chosen],
            rigid_modes=int(np.count_nonzero(chosen < self.rigid_modes)),
            complete=self.complete and bool((chosen == np.arange(chosen.size)).all()),
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the modes to ``path``, all or nothing, as an ``.npz`` that ``np.load`` opens.

        Raises:
            DefoError: the file cannot be written.
        """
        arrays: dict[str, NDArray[Any]] = {n: np.asarray(getattr(self, n)) for n in _ARRAYS}
        write_archive(path, arrays, kind=_KIND, version=_VERSION, units=_UNITS)


def load_modes(path: str | os.PathLike[str]) -> Modes:
    """Read modes that `Modes.save` wrote; needs NumPy only and executes nothing of the file.

    Raises:
        FileFormatError: the file is missing, damaged, from a newer version, or not of modes.
    """
    arrays = read_archive(path, kind=_KIND, version=_VERSION, required=_ARRAYS)
    values: dict[str, Any] = arrays | {"cell_type": str(arrays["cell_type"])}
    try:
        return Modes(**values)
    except ValueError as error:
        raise FileFormatError(f"{path}: is inconsistent: {error}.") from error
