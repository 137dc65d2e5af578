"""One candidate, measured: its motion against the reference, and what it costs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError
from fenics_defo.runtime import ReducedModel
from fenics_defo.scene.records import Scene
from fenics_defo.scene.trade.comparing import Yardstick
from fenics_defo.scene.trade.full import Recorded
from fenics_defo.scene.trade.records import FAILED, MEASURED, Candidate, Measurement
from fenics_defo.scene.trade.sampling import Sampling
from fenics_defo.scene.trade.timing import (
    BATCH,
    batch_rate,
    check_finite,
    motion_of,
    scene_of,
    step_seconds,
)

Array = NDArray[np.float64]


def measure_full(candidate: Candidate, run: Recorded, yardstick: Yardstick) -> Measurement:
    """What a run of the whole body gives.

    Args:
        candidate: of full order.
        run: its states at the times of comparison.
        yardstick: the reference.
    """
    errors = np.array([yardstick.error(i, u) for i, u in enumerate(run.displacements)])
    node, axis = yardstick.component()
    track = run.displacements[:, node, axis]
    return Measurement(
        candidate=candidate,
        status=MEASURED,
        **yardstick.summary(errors, run.energies, run.probes, track),
        **_times(candidate, run.seconds),
        offline_seconds=0.0,
    )


def measure_model(
    candidate: Candidate,
    model: ReducedModel,
    scene: Scene,
    *,
    yardstick: Yardstick,
    sampling: Sampling,
    costs: dict[str, Any],
) -> Measurement:
    """What a model gives; a failure is an answer too.

    Args:
        candidate: method of a model.
        model: with all nodes.
        scene: scene.
        yardstick: the reference.
        sampling: times of comparison.
        costs: ``offline_seconds``, ``model_bytes`` and ``best_error`` of the model.
    """
    own = scene_of(candidate, scene)
    try:
        found = _followed(candidate, model, own, yardstick, sampling)
        times = _times(candidate, step_seconds(candidate, model, own))
    except DefoError as error:
        return failure(candidate, error, costs)
    rate = None
    try:
        rate = batch_rate(candidate, model, own)
    except DefoError:  # what one body does, many may not: the choice does not depend on it
        rate = None
    return Measurement(
        candidate=candidate,
        status=MEASURED,
        **found,
        **times,
        **costs,
        batch=None if rate is None else BATCH,
        batch_rate=rate,
    )


def failure(candidate: Candidate, error: DefoError, costs: dict[str, Any]) -> Measurement:
    """The record of a candidate that could not be made or run.

    Args:
        candidate: which.
        error: what it said.
        costs: what is known nevertheless.
    """
    reason = getattr(error, "reason", "") or " ".join(str(error).split())
    return Measurement(candidate=candidate, status=FAILED, reason=reason, **costs)


def _followed(
    candidate: Candidate,
    model: ReducedModel,
    scene: Scene,
    yardstick: Yardstick,
    sampling: Sampling,
) -> dict[str, Any]:
    """Errors of a motion, state by state: all of its states would be as large as the reference."""
    node, axis = yardstick.component()
    errors, energies, probes, track = [], [], [], []
    with np.errstate(over="ignore", invalid="ignore"):
        motion = motion_of(candidate, model, scene)
        each = sampling.stride // candidate.factor
        for number in range(sampling.count):
            for _ in range(each if number else 0):
                motion.advance()
            displacement, energy = motion.state.displacement, motion.energies
            check_finite(displacement)
            errors.append(yardstick.error(number, displacement))
            energies.append((energy.kinetic, energy.strain))
            probes.append([motion.probe(name) for name in yardstick.probes])
            track.append(displacement[node, axis])
    shape = (len(errors), len(yardstick.probes), 3)
    return yardstick.summary(
        np.array(errors), np.array(energies), np.array(probes).reshape(shape), np.array(track)
    )


def _times(candidate: Candidate, seconds: Array) -> dict[str, Any]:
    median, late = (1e6 * float(np.percentile(seconds, p)) for p in (50, 99))
    return {
        "microseconds": median,
        "microseconds_p99": late,
        "real_time": 1e6 * candidate.step / median,
    }
