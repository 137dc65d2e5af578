"""What has been measured, kept under a key of all that it depends on."""

import contextlib
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo import __version__
from fenics_defo.runtime import atomic_path
from fenics_defo.scene.carried import body_identity
from fenics_defo.scene.records import Scene
from fenics_defo.scene.trade.records import Candidate, Measurement

Array = NDArray[np.float64]


class Store:
    """A folder of files by key; a file that is damaged is as if it were not there.

    Args:
        folder: made if it is missing.
        scene: scene; its mesh, and the version of the package, are part of every key.
    """

    def __init__(self, folder: Path, scene: Scene) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self._scene = scene_key(scene)

    def path(self, what: Any, suffix: str) -> Path:
        """Name of the file of something.

        Args:
            what: plain values that tell it from all else of the scene.
            suffix: of the file.
        """
        return self._folder / f"{_digest([self._scene, what])[:20]}{suffix}"

    def measurement(self, candidate: Candidate) -> Measurement | None:
        """What was measured of a candidate, if it was."""
        path = self.path(asdict(candidate), ".json")
        with contextlib.suppress(OSError, ValueError, TypeError, KeyError):
            return _measurement(json.loads(path.read_text("utf-8")), candidate)
        return None

    def keep(self, measurement: Measurement) -> None:
        """Keep what was measured of a candidate."""
        path = self.path(asdict(measurement.candidate), ".json")
        with atomic_path(path) as name:
            name.write_text(json.dumps(asdict(measurement)), "utf-8")

    def arrays(self, what: Any) -> dict[str, Array] | None:
        """Arrays kept of something, if they were."""
        path = self.path(what, ".npz")
        # A damaged archive fails in many ways, each of which means that it is to be made again.
        with contextlib.suppress(Exception), np.load(path, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name]) for name in archive.files}
        return None

    def keep_arrays(self, what: Any, arrays: Mapping[str, Array]) -> None:
        """Keep arrays of something."""
        with atomic_path(self.path(what, ".npz")) as name:
            np.savez(name, allow_pickle=False, **arrays)


def scene_key(scene: Scene) -> str:
    """Digest of all that a measurement depends on: not what is required of it, nor the output."""
    parts = {
        "version": __version__,
        "body": body_identity(scene),
        "outputs": scene.require.outputs,
        **{
            name: [asdict(item) for item in items] if isinstance(items, tuple) else asdict(items)
            for name in ("time", "fixed", "loads", "damping", "solver", "probes", "initial")
            for items in [getattr(scene, name)]
        },
    }
    return _digest(parts)


def _digest(value: Any) -> str:
    text = json.dumps(value, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def _measurement(record: dict[str, Any], candidate: Candidate) -> Measurement:
    known = {field.name for field in fields(Measurement)}
    if set(record) != known:
        raise ValueError("of another version")
    record |= {"candidate": candidate, "errors": tuple(record["errors"])}
    return Measurement(**record)
