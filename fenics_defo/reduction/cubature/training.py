"""From a body and a basis to a cubature of any energy, judged by poses held out from training."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.cubature.candidates import (
    LawPoints,
    candidates,
    stresses,
    total_force,
)
from fenics_defo.reduction.cubature.poses import Cloud, PoseSampler, rest_stiffness
from fenics_defo.reduction.cubature.selection import Curve, Pool, Poses, Selection, select
from fenics_defo.runtime.forces import CubatureForce

Array = NDArray[np.float64]

type PoseKind = Literal["statics", "sampled"]
type Method = Literal["greedy", "ecsw"]

#: Candidates looked at for each point by the greedy method.
SUBSET = 1000
#: Poses for each coordinate, and the fewest.
_POSES_EACH, _FEWEST = 4, 60
_EACH_HELD_OUT = 4  # one held-out pose for so many


@dataclass(frozen=True, slots=True, eq=False)
class CubatureTraining:
    """A trained cubature and all that is known of its error.

    Args:
        force: the law.
        curve: errors as points were added.
        tolerance: error at the training poses that was asked for [-].
        poses: coordinates of the training poses (t, r).
        strains: largest strain ‖Fᵀ F − I‖ / 2 of each training pose (t,) [-].
        kind: "statics", "sampled" or "given".
        redrawn: poses drawn again because a cell was inside out.
        seed: of all that is random.
        candidates: number of points to choose from.
        rest_error: largest relative error of a frequency at rest within the basis, before any
            correction [-].
        seconds: by phase.
        advice: what to do where the tolerance was not reached, or the held-out error is above
            twice the tolerance; None where all is well.
    """

    force: CubatureForce
    curve: Curve
    tolerance: float
    poses: Array
    strains: Array
    kind: str
    redrawn: int
    seed: int
    candidates: int
    rest_error: float
    seconds: dict[str, float]
    advice: str | None

    @property
    def points(self) -> int:
        """Number of points."""
        return self.force.points

    @property
    def training_error(self) -> float:
        """Root mean square of ‖f̂ − f‖ / ‖f‖ over the training poses [-]."""
        return float(self.curve.training[-1])

    @property
    def held_out_error(self) -> float:
        """The same over poses that the weights were not fitted to [-]."""
        return float(self.curve.held_out[-1])

    def certificate(self) -> dict[str, Any]:
        """What a model says of its cubature, in plain values."""
        return {
            "points": self.points,
            "candidates": self.candidates,
            "tolerance": self.tolerance,
            "training_error": self.training_error,
            "held_out_error": self.held_out_error,
            "poses": len(self.poses),
            "pose_kind": self.kind,
            "redrawn": self.redrawn,
            "largest_strain": float(self.strains.max()),
            "largest_coordinates": np.abs(self.poses).max(axis=0).tolist(),
            "rest_frequency_error": self.rest_error,
            "keeps_rest_stiffness": self.force.correction is not None,
            "seed": self.seed,
            "advice": self.advice,
        }


def train_cubature(
    solid: Solid,
    shapes: ArrayLike,
    *,
    tolerance: float = 0.01,
    most: int | None = None,
    poses: PoseKind | ArrayLike = "statics",
    count: int | None = None,
    strain: float = 0.2,
    seed: int = 0,
    method: Method = "greedy",
    keep_rest_stiffness: bool = False,
    observe: Callable[[int, float, float], None] | None = None,
) -> CubatureTraining:
    """Choose points and weights for a body's laws within a basis; collective.

    Candidates are the points of the body's own quadrature: with all of them, at their own weights,
    the sum is the body's reduced force. Each training pose counts by its relative error. An
    interruption from the keyboard keeps the best set reached.

    Args:
        solid: body.
        shapes: U (r, n, 3), nodes in the order of the user's file.
        tolerance: error at the training poses at which to stop [-].
        most: number of points at which to stop; 20 a coordinate if not given.
        poses: "statics", equilibria under random loads; "sampled", random coordinates scaled by
            frequency, which stretch where a body would bend; or coordinates (t, r) of poses of your
            own, of which every fifth judges and the others train.
        count: number of training poses; 4 a coordinate, at least 60, if not given.
        strain: largest strain ‖Fᵀ F − I‖ / 2 of poses that are drawn [-].
        seed: of all that is random.
        method: "greedy", each point from a random subset of the candidates (An, Kim and James
            2008); or "ecsw", each from all of them (Farhat et al. 2014).
        keep_rest_stiffness: add to the law what it lacks of the exact stiffness at rest.
        observe: called with the number of points, the training and the held-out error.

    Raises:
        DefoError: an argument out of its range, or poses that turn cells inside out.
        MaterialError: springs, which have no points.
    """
    U = np.asarray(shapes, np.float64)
    _check(tolerance, most, count, strain, method)
    seconds: dict[str, float] = {}
    with _timed(seconds, "candidates"):
        groups = candidates(solid, U)
        random = np.random.default_rng(seed)
        sampler = PoseSampler(groups, solid.comm, random)
    with _timed(seconds, "poses"):
        kind, train, judge = _clouds(sampler, poses, count or _pose_count(len(U)), strain)
        training = _answered(groups, train, solid)
        held_out = replace(_answered(groups, judge, solid), answers=())
    with _timed(seconds, "selection"):
        pool = Pool(groups, training, solid.comm)
        chosen = select(
            pool,
            training,
            held_out,
            tolerance=tolerance,
            most=most or 20 * len(U),
            subset=SUBSET if method == "greedy" else None,
            random=random,
            observe=observe,
        )
    if not len(chosen.numbers):
        raise DefoError("the training ended before it had a point; let it run longer")
    force = assembled(groups, chosen, solid)
    exact = rest_stiffness(groups, solid.comm)
    lack = exact - force.stiffness(np.zeros(force.size))
    if keep_rest_stiffness:
        force = _with_correction(force, lack)
    return CubatureTraining(
        force=force,
        curve=chosen.curve,
        tolerance=tolerance,
        poses=train.coordinates,
        strains=train.strains,
        kind=kind,
        redrawn=train.redrawn + judge.redrawn,
        seed=seed,
        candidates=pool.size,
        rest_error=_frequency_error(exact, lack),
        seconds=seconds,
        advice=_advice(chosen, tolerance),
    )


def assembled(groups: tuple[LawPoints, ...], chosen: Selection, solid: Solid) -> CubatureForce:
    """The law of some candidates, gathered from the ranks that have them; collective."""
    parts = []
    for points in groups:
        own = np.isin(points.numbers, chosen.numbers)
        numbers = points.numbers[own]
        weights = chosen.weights[np.searchsorted(chosen.numbers, numbers)]
        local = numbers, weights, points.gradients[own], points.parameters[:, own].T
        everywhere = [np.concatenate(x) for x in zip(*solid.comm.allgather(local), strict=True)]
        order = np.argsort(everywhere[0])
        if len(order):
            parts.append((points.law, *(column[order] for column in everywhere[1:])))
    laws, each, gradients, parameters = zip(*parts, strict=True)
    return CubatureForce(
        np.concatenate(each),
        np.concatenate(gradients),
        laws,
        tuple(len(column) for column in each),
        tuple(np.ascontiguousarray(values.T) for values in parameters),
    )


def _check(
    tolerance: float, most: int | None, count: int | None, strain: float, method: str
) -> None:
    if not 0.0 < tolerance < 1.0:
        raise DefoError(
            f"the tolerance of a cubature must lie between 0 and 1, got {tolerance!r}; 0.01 is "
            "one per cent of the force"
        )
    for name, number in (("most", most), ("count", count)):
        if number is not None and not number >= 1:
            raise DefoError(f"{name} must be at least 1, got {number!r}")
    if not 0.0 < strain < np.inf:
        raise DefoError(f"the largest strain of the poses must be positive, got {strain!r}")
    if method not in ("greedy", "ecsw"):
        raise DefoError(f"method must be 'greedy' or 'ecsw', got {method!r}")


def _pose_count(size: int) -> int:
    return max(_FEWEST, _POSES_EACH * size)


def _clouds(
    sampler: PoseSampler, poses: PoseKind | ArrayLike, count: int, strain: float
) -> tuple[str, Cloud, Cloud]:
    if isinstance(poses, str):
        if poses not in ("statics", "sampled"):
            raise DefoError(
                f"poses must be 'statics', 'sampled' or an array of coordinates, got {poses!r}"
            )
        draw = sampler.statics if poses == "statics" else sampler.sampled
        return poses, draw(count, strain), draw(-(-count // _EACH_HELD_OUT), strain)
    given = np.asarray(poses, np.float64)
    if given.ndim != 2 or given.shape[1] != sampler.size or len(given) < 2:
        raise DefoError(
            f"poses of your own must be coordinates (t, {sampler.size}), at least two, got "
            f"{given.shape}"
        )
    judging = np.arange(len(given)) % 5 == 1
    return "given", sampler.measured(given[~judging]), sampler.measured(given[judging])


def _answered(groups: tuple[LawPoints, ...], cloud: Cloud, solid: Solid) -> Poses:
    answers = tuple(stresses(points, cloud.coordinates) for points in groups)
    forces = total_force(groups, answers, solid.comm)
    if not (np.isfinite(forces).all() and (np.linalg.norm(forces, axis=1) > 0.0).all()):
        raise DefoError(
            "the reduced force of a training pose is zero or not finite; train to a smaller strain"
        )
    return Poses(cloud.coordinates, forces, answers)


def _with_correction(force: CubatureForce, lack: Array) -> CubatureForce:
    return CubatureForce(
        force.weights,
        force.gradients,
        force.laws,
        force.counts,
        force.parameters,
        0.5 * (lack + lack.T),
    )


def _frequency_error(exact: Array, lack: Array) -> float:
    """Largest |ω̂ / ω − 1| over all directions of the basis: of Rayleigh's quotients of K̂ in K."""
    values, vectors = np.linalg.eigh(0.5 * (exact + exact.T))
    scaled = vectors / np.sqrt(values)
    relative = np.linalg.eigvalsh(scaled.T @ (0.5 * (lack + lack.T)) @ scaled)
    ratios = np.sqrt(np.maximum(1.0 - relative, 0.0))
    return float(np.abs(ratios - 1.0).max())


def _advice(chosen: Selection, tolerance: float) -> str | None:
    training, held_out = chosen.curve.training[-1], chosen.curve.held_out[-1]
    if training > tolerance:
        return (
            f"the error at the training poses is {training:.3g}, above the tolerance "
            f"{tolerance:.3g}: allow more points"
        )
    if held_out > 2.0 * tolerance:
        return (
            f"the error at held-out poses is {held_out:.3g}, above twice the tolerance "
            f"{tolerance:.3g}: train with more poses"
        )
    return None


class _timed:
    """Adds the seconds of a with statement to a phase."""

    def __init__(self, seconds: dict[str, float], name: str) -> None:
        self._seconds, self._name = seconds, name

    def __enter__(self) -> None:
        self._begin = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self._seconds[self._name] = time.perf_counter() - self._begin
