"""What a trade-off is told in: candidates, what was measured of them, and the choice."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

#: Kinds of what moves: all of the body, a model stepped, a linear model by its exact filter.
FULL, REDUCED, FILTER = "full", "reduced", "filter"
#: What became of a candidate.
MEASURED, PRUNED, FAILED = "measured", "pruned", "failed"

_BASES = {"linear": "modes", "modal-derivatives": "derivatives", "snapshots": "training motion"}


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class ModelSpec:
    """A model that could be made of a scene's body.

    Args:
        basis: "linear" (vibration modes), "modal-derivatives", or "snapshots" of the reference.
        size: number r of coordinates.
        force: "linear", "cubic", "taylor" or "cubature".
        tolerance: of a cubature at its training poses [-].
    """

    basis: str
    size: int
    force: str
    tolerance: float | None = None

    @property
    def name(self) -> str:
        """As in a table."""
        tolerance = "" if self.tolerance is None else f" {100 * self.tolerance:g} %"
        return f"{self.force}{tolerance}, r = {self.size}, {_BASES[self.basis]}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A way to move a scene's body.

    Args:
        kind: `FULL`, `REDUCED` or `FILTER`.
        model: of `REDUCED` and `FILTER`.
        law: of `FULL`: "" for the scene's own, "corotational" or "linear".
        integrator: method; the scene's words for it.
        step: time step [s].
        factor: the scene's step times this is ``step``.
    """

    kind: str
    integrator: str
    step: float
    factor: int = 1
    model: ModelSpec | None = None
    law: str = ""

    @property
    def is_trained(self) -> bool:
        """Whether its basis is made from the reference itself."""
        return self.model is not None and self.model.basis == "snapshots"

    @property
    def name(self) -> str:
        """As in a table, without the step."""
        if self.model is None:
            return f"full order, {self.law or 'the same law'}"
        exact = ", exact filter" if self.kind == FILTER else ""
        return self.model.name + exact


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What was measured of a candidate. Numbers that were not measured are None.

    Errors are relative to the reference's largest displacement (energy, frequency) over the whole
    motion. Displacements are weighed by the mass at the nodes, of the outputs if they were asked
    for, else of the whole body.

    Args:
        candidate: what was measured.
        status: `MEASURED`, `PRUNED` or `FAILED`.
        reason: why it was not measured.
        error: largest over time [-].
        error_rms: root mean square over time [-].
        error_whole: largest over time, of the whole body [-].
        errors: over the times of `Reference.times` (m,) [-].
        best_error: largest over time of the best that its basis can do, whatever its forces [-].
        probe_errors: largest over time by probe, relative to the probe's largest displacement [-].
        energy_error: largest of kinetic + strain energy, relative to the reference's largest [-].
        frequency: strongest of the motion [Hz]; None where too few periods were seen.
        frequency_error: relative to the reference's [-].
        microseconds: median time of a step [µs].
        microseconds_p99: 99th percentile.
        real_time: simulated over spent time [-].
        offline_seconds: to make the model [s].
        model_bytes: size of its file.
        batch: number of bodies at once in ``batch_rate``.
        batch_rate: steps a second of a batch, bodies times steps [1/s].
    """

    candidate: Candidate
    status: str
    reason: str = ""
    error: float | None = None
    error_rms: float | None = None
    error_whole: float | None = None
    errors: tuple[float, ...] = ()
    best_error: float | None = None
    probe_errors: Mapping[str, float] = field(default_factory=dict)
    energy_error: float | None = None
    frequency: float | None = None
    frequency_error: float | None = None
    microseconds: float | None = None
    microseconds_p99: float | None = None
    real_time: float | None = None
    offline_seconds: float | None = None
    model_bytes: int | None = None
    batch: int | None = None
    batch_rate: float | None = None

    @property
    def cost(self) -> float | None:
        """Median time [µs] to carry the body on by one step of the scene."""
        return None if self.microseconds is None else self.microseconds / self.candidate.factor


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """The motion that candidates are held against: of full order, at half of the scene's step.

    Args:
        step: its time step [s].
        times: at which states are compared (m,) [s].
        error: its own, estimated from the run at twice its step [-].
        mesh_error: the mesh's, estimated by a run of second order [-]; None: not looked at.
        largest: displacement of a node [m].
        energy_ratio: ½ uᵀ K(0) u over the strain energy, likewise [-]: 1 for small displacements.
        frequency: strongest of the motion [Hz].
        unknowns: displacement components of the body.
    """

    step: float
    times: tuple[float, ...]
    error: float
    mesh_error: float | None
    largest: float
    energy_ratio: float | None
    frequency: float | None
    unknowns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Tradeoff:
    """Candidates of a scene, measured, and the choice.

    Args:
        scene: name of its file.
        title: what it is, a few words.
        step: of the scene [s].
        duration: of the scene [s].
        flies: whether nothing holds the body.
        tolerance: error that is allowed [-].
        is_default: whether the scene has none and this is the default.
        rate: steps a second that are asked for [Hz].
        reference: what they were held against.
        rows: all candidates, the cheapest first, then those that were not measured.
        front: numbers of the rows that no other beats in both error and cost.
        choice: number of the row that was chosen; None: none fits.
        reason: a sentence about the choice.
        misses: numbers of the rows that come nearest, where none fits.
        machine: that the times are of.
        model: name of the chosen model's file; empty: none.
        version: of the package.
    """

    scene: str
    title: str
    step: float
    duration: float
    flies: bool
    tolerance: float
    is_default: bool
    rate: float | None
    reference: Reference
    rows: tuple[Measurement, ...]
    front: tuple[int, ...]
    choice: int | None
    reason: str
    misses: tuple[int, ...]
    machine: Mapping[str, Any]
    model: str
    version: str

    @property
    def chosen(self) -> Measurement | None:
        """The row that was chosen."""
        return None if self.choice is None else self.rows[self.choice]
