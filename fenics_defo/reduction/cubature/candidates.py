"""The points that a cubature may choose from, and what they answer to training poses."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import material_law
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import MPI
from fenics_defo.fem.field_gradients import region_gradients
from fenics_defo.fem.input_order import cell_rows
from fenics_defo.fem.projection import Projection
from fenics_defo.runtime.laws import MaterialLaw, PointKernel
from fenics_defo.runtime.laws.kernel import IDENTITY

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Points of one block while gradients are formed, and points times poses while stresses are.
_POINTS = 4096
_STRESSES = 1 << 15


@dataclass(frozen=True, slots=True, eq=False)
class LawPoints:
    """This rank's candidates of one law.

    Args:
        law: theirs.
        parameters: (names, n).
        gradients: G (n, 9, r) [1/m].
        weights: of the body's own quadrature (n,) [m³].
        numbers: (n,) cell in the file's order times points a cell, plus the point: the same on any
            number of ranks.
    """

    law: MaterialLaw
    parameters: Array
    gradients: Array
    weights: Array
    numbers: IntArray


def candidates(solid: Solid, shapes: Array) -> tuple[LawPoints, ...]:
    """All quadrature points of a body, one group a law; collective.

    The rule is the one of the body's own energy, with which the sum over all candidates is the
    body's reduced force.

    Args:
        solid: body.
        shapes: U (r, n, 3).

    Raises:
        MaterialError: springs, which have no points.
        DefoError: shapes that are not the body's.
    """
    fields = Projection(solid, shapes).fields
    rows = cell_rows(solid.space.mesh)
    groups = []
    for region in solid.fields.regions:
        law = material_law(region.material)
        blocks = region_gradients(
            solid.space, region, fields, degree=solid.degrees.energy, points=_POINTS
        )
        parts = [_no_points(len(law.names), len(fields))]
        for block in blocks:
            each = len(block.weights) // len(block.cells)
            values = [block.at_points(region.parameters[name]) for name in law.names]
            parts.append(
                (
                    np.array(values).reshape(len(law.names), len(block.weights)),
                    block.gradients.reshape(len(fields), 9, -1).transpose(2, 1, 0).copy(),
                    block.weights,
                    (rows[block.cells] * each + np.arange(each)[:, None]).ravel(),
                )
            )
        groups.append(
            LawPoints(
                law=law,
                parameters=np.concatenate([part[0] for part in parts], axis=1),
                gradients=np.concatenate([part[1] for part in parts]),
                weights=np.concatenate([part[2] for part in parts]),
                numbers=np.concatenate([part[3] for part in parts]),
            )
        )
    return tuple(groups)


def _no_points(names: int, size: int) -> tuple[Array, Array, Array, IntArray]:
    """What a rank without cells of a law has."""
    return np.zeros((names, 0)), np.zeros((0, 9, size)), np.zeros(0), np.zeros(0, np.int64)


def stresses(points: LawPoints, poses: Array) -> Array:
    """P (n, t, 9) [Pa] of a law's candidates at poses (t, r); not finite where it has no answer."""
    count, poses_count = len(points.weights), len(poses)
    stress = np.empty((count, poses_count, 9))
    kernels = _Kernels(points, poses_count)
    for part in _blocks(count, max(1, _STRESSES // max(poses_count, 1))):
        size = part.stop - part.start
        kernel = kernels(part)
        moved = points.gradients[part].reshape(-1, poses.shape[1]) @ poses.T
        kernel.gradients[:] = moved.reshape(size, 9, -1).transpose(1, 0, 2).reshape(9, -1)
        kernel.gradients += IDENTITY[:, None]
        with np.errstate(all="ignore"):
            stress[part] = kernel.stress().reshape(9, size, -1).transpose(1, 2, 0)
    return stress


class _Kernels:
    """The law's kernel for blocks of points, each repeated for every pose."""

    def __init__(self, points: LawPoints, poses: int) -> None:
        self._points, self._poses = points, poses
        self._uniform = bool((points.parameters == points.parameters[:, :1]).all())
        self._last: PointKernel | None = None

    def __call__(self, part: slice) -> PointKernel:
        """The kernel for some points; the last one again where that serves."""
        count = (part.stop - part.start) * self._poses
        if self._uniform:
            if self._last is None or self._last.gradients.shape[1] != count:
                self._last = self._points.law.kernel(self._points.parameters[:, 0].tolist(), count)
            return self._last
        values = [np.repeat(row[part], self._poses) for row in self._points.parameters]
        return self._points.law.kernel(values, count)


def volumes(points: LawPoints, poses: Array) -> tuple[Array, Array]:
    """Largest strain ‖Fᵀ F − I‖ / 2 and smallest det F (t,) over a law's candidates here."""
    strain, volume = np.zeros(len(poses)), np.full(len(poses), np.inf)
    for part in _blocks(len(points.weights), max(1, _STRESSES // max(len(poses), 1))):
        moved = points.gradients[part].reshape(-1, poses.shape[1]) @ poses.T
        F = moved.reshape(-1, 9, len(poses)).transpose(1, 0, 2) + IDENTITY[:, None, None]
        strain = np.maximum(strain, _strain(F).max(axis=0, initial=0.0))
        volume = np.minimum(volume, _volume(F).min(axis=0, initial=np.inf))
    return strain, volume


def total_force(groups: tuple[LawPoints, ...], answers: tuple[Array, ...], comm: MPI.Comm) -> Array:
    """F (t, r) at the poses by all candidates with the body's own weights; collective."""
    r, t = groups[0].gradients.shape[2], answers[0].shape[1]
    local = np.zeros((r, t))
    for points, stress in zip(groups, answers, strict=True):
        for part in _blocks(len(points.weights), _POINTS):
            scaled = points.gradients[part] * points.weights[part, None, None]
            local += scaled.reshape(-1, r).T @ stress[part].transpose(0, 2, 1).reshape(-1, t)
    total = np.empty_like(local)
    comm.Allreduce(local, total)
    return total.T.copy()


def some_points(points: LawPoints, chosen: NDArray[Any]) -> LawPoints:
    """Some of the candidates of a law, by places or by a mask."""
    return LawPoints(
        law=points.law,
        parameters=points.parameters[:, chosen],
        gradients=points.gradients[chosen],
        weights=points.weights[chosen],
        numbers=points.numbers[chosen],
    )


def _blocks(count: int, size: int) -> Iterator[slice]:
    for begin in range(0, count, size):
        yield slice(begin, min(begin + size, count))


def _strain(F: Array) -> Array:
    """‖Fᵀ F − I‖ / 2 of gradients (9, ...)."""
    X = F.reshape(3, 3, *F.shape[1:])
    total = np.zeros(F.shape[1:])
    for a in range(3):
        for b in range(a, 3):
            entry = np.einsum("i...,i...->...", X[:, a], X[:, b])
            entry -= a == b
            entry *= entry
            total += entry if a == b else 2.0 * entry
    return 0.5 * np.sqrt(total)


def _volume(F: Array) -> Array:
    """Det F of gradients (9, ...)."""
    a, b, c, d, e, f, g, h, i = F
    volume: Array = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return volume
