"""From a body and a basis to a cubature of any energy, judged by poses held out from training."""

import time
from dataclasses import replace
from typing import Literal

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
from fenics_defo.reduction.cubature.chosen_law import assembled, corrected, frequency_error
from fenics_defo.reduction.cubature.pool import Pool, Poses
from fenics_defo.reduction.cubature.poses import Cloud, PoseSampler, rest_stiffness
from fenics_defo.reduction.cubature.progress import Observer
from fenics_defo.reduction.cubature.result import CubatureTraining
from fenics_defo.reduction.cubature.selection import Search, Selection, select

Array = NDArray[np.float64]

type PoseKind = Literal["statics", "sampled"]
type Method = Literal["thinned", "greedy", "ecsw"]

#: Candidates looked at for each point where not all are.
SUBSET = 1000
_SEARCHES = {
    "thinned": Search(subset=SUBSET, finalists=50, rounds=6),
    "greedy": Search(subset=SUBSET),
    "ecsw": Search(subset=None),
}
#: Poses for each coordinate, and the fewest.
_POSES_EACH, _FEWEST = 4, 60
_EACH_HELD_OUT = 4  # one held-out pose for so many


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
    method: Method = "thinned",
    keep_rest_stiffness: bool = False,
    observe: Observer | None = None,
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
            2008); "ecsw", each from all of them (Farhat et al. 2014); or "thinned", from a random
            subset with orthogonal projection, and points that are not needed taken away again.
        keep_rest_stiffness: add to the law what it lacks of the exact stiffness at rest.
        observe: called after each point with the `Progress`.

    Raises:
        DefoError: an argument out of its range, or poses that turn cells inside out.
        MaterialError: springs, which have no points.
        KeyboardInterrupt: before there was a point.
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
            search=_SEARCHES[method],
            random=random,
            comm=solid.comm,
            observe=observe,
        )
    force = assembled(groups, chosen.numbers, chosen.weights, solid.comm)
    exact = rest_stiffness(groups, solid.comm)
    lack = exact - force.stiffness(np.zeros(force.size))
    return CubatureTraining(
        force=corrected(force, lack) if keep_rest_stiffness else force,
        curve=chosen.curve,
        tolerance=tolerance,
        poses=train.coordinates,
        strains=train.strains,
        kind=kind,
        redrawn=train.redrawn + judge.redrawn,
        seed=seed,
        candidates=pool.size,
        rest_error=frequency_error(exact, lack),
        seconds=seconds,
        training_error=chosen.training,
        held_out_error=chosen.held_out,
        method=method,
        advice=_advice(chosen, tolerance),
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
    if method not in _SEARCHES:
        raise DefoError(f"method must be one of {', '.join(map(repr, _SEARCHES))}, got {method!r}")


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


def _advice(chosen: Selection, tolerance: float) -> str | None:
    training, held_out = chosen.training, chosen.held_out
    if chosen.is_interrupted:
        return f"the training was interrupted at an error of {training:.3g}: let it run to its end"
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
