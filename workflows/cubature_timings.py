"""Times of cubature and of its training, in seconds of this process's processor time."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import common
import numpy as np
from timings import STEP, alternate, cubic_model, loads_of

from fenics_defo import analysis, energy, fem, reduction
from fenics_defo.reduction.cubature.result import CubatureTraining
from fenics_defo.runtime import ReducedModel, integrators
from fenics_defo.runtime.integrators.dense_solver import solve

type Row = dict[str, Any]

RUBBER = energy.NeoHookean(young=1e6, poisson=0.4, density=1000.0)
TINY_TRAININGS = (((8, 2, 2), 4, 20, None), ((12, 2, 2), 4, 20, None))


@dataclass(frozen=True, slots=True, eq=False)
class Beam:
    """A clamped beam and its basis.

    Args:
        solid: body.
        basis: r modes and modal derivatives.
    """

    solid: fem.Solid
    basis: reduction.Basis

    @classmethod
    def of(cls, cells: Sequence[int], r: int, material: energy.Law = RUBBER) -> "Beam":
        """A beam 4 x 1 x 1 m of six tetrahedra to a brick."""
        solid = fem.Solid(common.box((4.0, 1.0, 1.0), cells), material, fixed=["x<1e-6"])
        modes = analysis.linear_modes(solid, 3 + r // 3, verify=False)
        return cls(solid, reduction.modal_derivative_basis(solid, modes, size=r))

    def trained(self, tolerance: float, **options: Any) -> tuple[ReducedModel, CubatureTraining]:
        """A model with cubature, and its training."""
        training = reduction.train_cubature(
            self.solid, self.basis.shapes, tolerance=tolerance, **options
        )
        model = reduction.reduce(self.solid, self.basis, "cubature", training=training)
        return model, training


def step_row(
    model: ReducedModel, training: CubatureTraining, bodies: int, *, seconds: float
) -> Row:
    """Force, force and tangent, solve and a whole Newmark step, beside the floor."""
    r, points = model.size, training.points
    shape = (r,) if bodies == 1 else (bodies, r)
    load = 1e-3 * loads_of(model, bodies).reshape(shape)
    motion = integrators.ImplicitNewmark(model, step=STEP, batch=None if bodies == 1 else bodies)
    evaluator = model.law.evaluator(shape)
    q, x = np.full(shape, 1e-4), np.empty(shape)
    matrix = np.array(evaluator.force_and_stiffness(q)[1]) + 4.0 / STEP**2 * np.eye(r)
    times = alternate(
        {
            "floor": _floor(points, r, bodies),
            "force": lambda: evaluator.force(q),
            "force and tangent": lambda: evaluator.force_and_stiffness(q),
            "solve": lambda: solve(matrix, load, x),
            "step": lambda: motion.advance(load),
        },
        seconds=seconds,
    )
    return {
        "r": r,
        "bodies": bodies,
        "points": points,
        "tolerance": training.tolerance,
        "held_out": training.held_out_error,
        **times,
        "finite": bool(np.isfinite(motion.q).all()),
    }


def _floor(points: int, r: int, bodies: int) -> Any:
    """The two products through the point gradients, for a few bodies again and again."""
    together = min(bodies, 16)
    rounds = -(-bodies // together)
    gradients, tangents = np.ones((points, 9, r)), np.ones((points, 9 * together, 9))
    product = np.empty((points, 9 * together, r))
    rows, table = np.ones((9 * points, r)), product.reshape(9 * points, together * r)
    result = np.empty((r, together * r))

    def work() -> None:
        for _ in range(rounds):
            np.matmul(tangents, gradients, out=product)
            np.dot(rows.T, table, out=result)

    return work


def cubic_row(r: int, *, seconds: float) -> Row:
    """A step with a cubic force of r coordinates."""
    model = cubic_model(r)
    motion = integrators.ImplicitNewmark(model, step=STEP)
    load = loads_of(model, 1)[0]
    return {"r": r, **alternate({"step": lambda: motion.advance(load)}, seconds=seconds)}


def training_row(cells: Sequence[int], r: int, poses: int, goal: float | None) -> Row:
    """A training to 1 %, without the modes and the basis."""
    beam = Beam.of(cells, r)
    begin = time.process_time()
    _, training = beam.trained(0.01, count=poses)
    return {
        "tets": 6 * int(np.prod(cells)),
        "r": r,
        "poses": poses,
        "points": training.points,
        "held_out": training.held_out_error,
        "seconds": time.process_time() - begin,
        "phases": training.seconds,
        "goal": goal,
    }
