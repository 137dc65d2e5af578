"""How far a motion is from the reference, state by state."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import SceneError
from fenics_defo.scene.trade.full import Recorded
from fenics_defo.scene.trade.spectrum import strongest_frequency

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """The reference, and how states are weighed.

    Args:
        reference: states at the times of comparison.
        masses: of the nodes (n,) [kg].
        outputs: numbers of the nodes that are looked at; None: all.
        interval: time between two states [s].
        probes: names of the probes.
    """

    reference: Recorded
    masses: Array
    outputs: NDArray[np.int64] | None
    interval: float
    probes: tuple[str, ...]
    _scales: dict[str, float] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        whole = max(self._norm(u, None) for u in self.reference.displacements)
        asked = max(self._norm(u, self.outputs) for u in self.reference.displacements)
        self._scales.update(whole=whole, asked=asked)

    def check_moves(self, scene: str) -> None:
        """Make sure that errors have something to be relative to.

        Raises:
            SceneError: nothing moves.
        """
        if not self._scales["asked"] > 0.0:
            raise SceneError(
                f"{scene}: nothing moves at the outputs, so no error can be told; give the scene a "
                "load or an initial state, or look at other nodes"
            )

    def error(self, number: int, displacement: Array) -> tuple[float, float]:
        """Errors of a state at the outputs and of the whole body [-]."""
        apart = displacement - self.reference.displacements[number]
        asked = self._norm(apart, self.outputs) / self._scales["asked"]
        return asked, self._norm(apart, None) / self._scales["whole"]

    def best_errors(self, shapes: Array) -> Array:
        """Error (r,) that the first 1, 2, ... shapes (r, n, 3) have at least at the outputs [-]."""
        rows = slice(None) if self.outputs is None else self.outputs
        roots = np.sqrt(self.masses[rows])[:, None]
        columns = (shapes[:, rows] * roots).reshape(len(shapes), -1).T
        orthonormal = np.linalg.qr(columns)[0]
        least = np.zeros(orthonormal.shape[1])
        for displacement in self.reference.displacements:
            target = (displacement[rows] * roots).ravel()
            left = target @ target - np.cumsum((orthonormal.T @ target) ** 2)
            least = np.maximum(least, np.sqrt(np.maximum(left, 0.0)))
        # Where there are more shapes than components at the outputs, the last do not count.
        filled = np.pad(least, (0, len(shapes) - len(least)), mode="edge")
        return filled / self._scales["asked"]

    def summary(
        self, errors: Array, energies: Array, probes: Array, track: Array
    ) -> dict[str, Any]:
        """Errors of a motion, by the names that a `Measurement` has for them.

        Args:
            errors: of each state at the outputs and of the whole body (m, 2) [-].
            energies: kinetic and strain (m, 2) [J].
            probes: (m, p, 3) [m].
            track: displacement of `component` (m,) [m].
        """
        reference = self.reference
        total = reference.energies.sum(axis=1)
        scale = float(np.abs(total).max())
        apart = np.abs(energies.sum(axis=1) - total).max()
        frequency, wanted = self.frequency(track), self.frequency(self.track())
        off = None if frequency is None or not wanted else abs(frequency / wanted - 1.0)
        return {
            "error": float(errors[:, 0].max()),
            "error_rms": float(np.sqrt(np.mean(errors[:, 0] ** 2))),
            "error_whole": float(errors[:, 1].max()),
            "errors": tuple(errors[:, 0].tolist()),
            "probe_errors": self._probe_errors(probes),
            "energy_error": float(apart / scale) if scale > 0.0 else None,
            "frequency": frequency,
            "frequency_error": off,
        }

    def component(self) -> tuple[int, int]:
        """Node and axis of the largest displacement."""
        largest = np.abs(self.reference.displacements).max(axis=0)
        node, axis = np.unravel_index(int(largest.argmax()), largest.shape)
        return int(node), int(axis)

    def track(self) -> Array:
        """The displacement of the reference there (m,) [m]."""
        node, axis = self.component()
        return np.asarray(self.reference.displacements[:, node, axis])

    def frequency(self, track: Array) -> float | None:
        """Strongest frequency of such a displacement [Hz]."""
        return strongest_frequency(track, self.interval)

    def _probe_errors(self, probes: Array) -> dict[str, float]:
        apart = np.linalg.norm(probes - self.reference.probes, axis=2)
        scale = np.linalg.norm(self.reference.probes, axis=2).max(axis=0, initial=0.0)
        return {
            name: float(apart[:, i].max() / scale[i])
            for i, name in enumerate(self.probes)
            if scale[i] > 0.0
        }

    def _norm(self, field: Array, rows: NDArray[np.int64] | None) -> float:
        chosen = slice(None) if rows is None else rows
        squares = np.einsum("nc,nc->n", field[chosen], field[chosen])
        return float(np.sqrt(self.masses[chosen] @ squares))
