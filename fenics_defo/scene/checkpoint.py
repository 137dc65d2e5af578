"""The state that a run goes on from, in one file that is there whole or not at all."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Energies, State
from fenics_defo.errors import FileFormatError
from fenics_defo.runtime import ArraySpec, read_archive, write_archive
from fenics_defo.scene.records import Scene

if TYPE_CHECKING:
    from fenics_defo.fem import Solid

_KIND, _VERSION = "checkpoint", 1
_UNITS = {
    "clock": "s",
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s2",
    "energies": "J",
    "frame_times": "s",
    "peaks": "m",
}
_REQUIRED = {
    "clock": ArraySpec("f", 1),
    "step": ArraySpec("i", 1),
    "displacement": ArraySpec("f", 2),
    "velocity": ArraySpec("f", 2),
    "acceleration": ArraySpec("f", 2),
    "energies": ArraySpec("f", 1),
    "sizes": ArraySpec("i", 1),
    "frame_times": ArraySpec("f", 1),
    "counts": ArraySpec("i", 1),
    "peaks": ArraySpec("f", 1),
    "scene": ArraySpec("U", 0),
}
# What may change between a run and its continuation: it does not change what has been computed.
_FREE_TABLES = ("output", "require", "solver")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """What a run adds up.

    Args:
        newton_iterations: linear solves of Newton's method.
        linear_iterations: of conjugate gradients.
        halvings: of steps.
        peaks: (p,) largest displacement of each probe so far [m].
    """

    newton_iterations: int
    linear_iterations: int
    halvings: int
    peaks: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkpoint:
    """A state, with what had been written when it was reached.

    Args:
        state: of the body.
        energies: of the body.
        sizes: lengths of the tables of probes and of energies [bytes].
        frame_times: times of the frames [s].
        tally: what the run has added up.
        identity: of the scene, see `scene_identity`.
    """

    state: State
    energies: Energies
    sizes: tuple[int, int]
    frame_times: tuple[float, ...]
    tally: Tally
    identity: Mapping[str, str]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the file, all of it or nothing.

        Raises:
            DefoError: it cannot be written.
        """
        state, energies, tally = self.state, self.energies, self.tally
        counts = [tally.newton_iterations, tally.linear_iterations, tally.halvings]
        arrays: dict[str, NDArray[Any]] = {
            "clock": np.array([state.time]),
            "step": np.array([state.step], np.int64),
            "displacement": state.displacement,
            "velocity": state.velocity,
            "acceleration": state.acceleration,
            "energies": np.array(
                [energies.kinetic, energies.strain, energies.external, energies.dissipated]
            ),
            "sizes": np.array(self.sizes, np.int64),
            "frame_times": np.array(self.frame_times, np.float64),
            "counts": np.array(counts, np.int64),
            "peaks": np.array(tally.peaks, np.float64),
            "scene": np.array(json.dumps(dict(self.identity))),
        }
        write_archive(path, arrays, kind=_KIND, version=_VERSION, units=_UNITS)


def load_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint; nothing in it is run.

    Raises:
        FileFormatError: the file is missing, damaged or of another kind.
    """
    arrays = read_archive(path, kind=_KIND, version=_VERSION, required=_REQUIRED)
    try:
        (time,), (step,) = arrays["clock"].tolist(), arrays["step"].tolist()
        kinetic, strain, external, dissipated = arrays["energies"].tolist()
        newton, linear, halvings = arrays["counts"].tolist()
        probes, energies = arrays["sizes"].tolist()
        identity = json.loads(str(arrays["scene"]))
        if not isinstance(identity, dict) or not all(isinstance(v, str) for v in identity.values()):
            raise ValueError("the scene is not named")
    except ValueError as error:
        raise FileFormatError(f"{path}: is damaged ({error}); run again from the start.") from error
    return Checkpoint(
        state=State(
            time=time,
            step=step,
            displacement=arrays["displacement"],
            velocity=arrays["velocity"],
            acceleration=arrays["acceleration"],
        ),
        energies=Energies(kinetic=kinetic, strain=strain, external=external, dissipated=dissipated),
        sizes=(probes, energies),
        frame_times=tuple(arrays["frame_times"].tolist()),
        tally=Tally(
            newton_iterations=newton,
            linear_iterations=linear,
            halvings=halvings,
            peaks=tuple(arrays["peaks"].tolist()),
        ),
        identity=identity,
    )


def scene_identity(scene: Scene, solid: "Solid") -> dict[str, str]:
    """What must be the same for a run to be continued: a text for each table that counts.

    Left out are the tables of output, solver and requirements and, but for statics, whose loads
    grow over it, the duration: a finished run may be made longer.
    """
    digest = hashlib.sha256(solid.points.tobytes() + solid.cells.tobytes()).hexdigest()
    identity = {"mesh": f"{digest} of order {solid.order}"}
    for name, table in scene.tables.items():
        if name == "mesh" or name in _FREE_TABLES:
            continue
        kept = table
        if name == "time" and not scene.time.is_static:
            kept = {key: value for key, value in table.items() if key != "duration"}
        identity[name] = json.dumps(kept, sort_keys=True, default=str)
    return identity


def changed_tables(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names of the tables that differ between two scenes."""
    return sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))
