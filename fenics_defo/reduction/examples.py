"""Example motions in all the forms that users have them in."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.fem import Solid
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.runtime.recording import read_series

Array = NDArray[np.float64]


class Displaced(Protocol):
    """A `State` of a motion, or an `Equilibrium`."""

    @property
    def displacement(self) -> Array:
        """(n, 3) [m]."""


class Moved(Protocol):
    """A `Motion`, of whose states the last is kept."""

    @property
    def state(self) -> Displaced:
        """At its end."""


type Snapshots = (
    str | os.PathLike[str] | ArrayLike | Displaced | Moved | Sequence[Displaced | Moved]
)


def example_motion(solid: Solid, snapshots: Snapshots) -> Array:
    """Displacements (s, n, 3) [m] of an example motion; their shape is not checked. Collective.

    Args:
        solid: body.
        snapshots: an array of that shape; a state, an equilibrium or a motion, or several; or a
            folder that ``fenics-defo simulate`` wrote, or the ``.pvd`` in it.

    Raises:
        DefoError: they are nothing of these.
        FileFormatError: the folder's series is missing, damaged, or of another body.
    """
    if isinstance(snapshots, str | os.PathLike):
        path = Path(snapshots)
        return on_first_rank(solid.comm, lambda: _recorded(solid, path))
    single = _displacement(snapshots)
    fields: object = snapshots if single is None else [single]
    if isinstance(fields, Iterable) and not isinstance(fields, np.ndarray):
        given = list(fields)
        taken = [_displacement(field) for field in given]
        fields = [f if d is None else d for f, d in zip(given, taken, strict=True)]
    try:
        return np.asarray(fields, np.float64)
    except (TypeError, ValueError) as error:
        raise DefoError(
            "snapshots must be an array (s, n, 3), states, or a folder that simulate wrote; got "
            f"{type(snapshots).__name__} ({error})"
        ) from error


def _displacement(thing: object) -> Array | None:
    """The displacement of a state, of an equilibrium, or at the end of a motion."""
    state = getattr(thing, "state", thing)
    found = getattr(state, "displacement", None)
    return found if isinstance(found, np.ndarray) else None


def _recorded(solid: Solid, path: Path) -> Array:
    series = read_series(path)
    points = series.points
    tolerance = 1e-6 * float(np.ptp(solid.points, axis=0).max())
    if points.shape != solid.points.shape or not (np.abs(points - solid.points).max() <= tolerance):
        raise FileFormatError(
            f"{path}: is a motion of another body, its {len(points)} nodes are not the "
            f"{len(solid.points)} of this one; simulate this mesh at this order."
        )
    return np.stack([series.frame(number)["displacement"] for number in range(series.size)])
