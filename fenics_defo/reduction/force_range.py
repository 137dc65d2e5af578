"""How far from rest a reduced force may be trusted: its error along sampled displacements."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.direct_force import DirectForce
from fenics_defo.runtime.forces.force_law import ForceLaw

Array = NDArray[np.float64]

# Largest nodal displacements that are sampled, as parts of the body's size.
_FROM, _TO, _COUNT = 1e-4, 0.5, 25
# Eigenvalues of K(0) below this part of the largest belong to rigid motions.
_RIGID = 1e-10


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceRange:
    """Errors of a reduced force along rays from rest.

    Args:
        directions: (k, r) q at which the farthest node has moved by 1 m.
        amplitudes: (a,) displacements of that node [m], ascending.
        errors: (k, a) |f - f_direct| / |f_direct| [-] in the norm of K(0)⁻¹; infinite where one is
            no number; NaN where it was not looked at, beyond the tolerance.
        tolerance: accepted error [-].
        reach: largest amplitude [m] to which all rays keep within the tolerance; 0 if none does.
    """

    directions: Array
    amplitudes: Array
    errors: Array
    tolerance: float
    reach: float

    def certificate(self) -> dict[str, float | int | list[float]]:
        """What a model keeps of it, in values that JSON can hold."""
        within = self.amplitudes <= self.reach
        return {
            "reach_m": self.reach,
            "tolerance": self.tolerance,
            "rays": len(self.directions),
            "amplitudes_m": self.amplitudes[within].tolist(),
            "largest_errors": self.errors[:, within].max(axis=0).tolist(),
        }


def measure_range(
    solid: Solid,
    law: ForceLaw,
    shapes: ArrayLike,
    *,
    tolerance: float = 0.01,
    rays: int = 8,
    seed: int = 0,
) -> ForceRange:
    """Compare a law with `DirectForce` along rays from rest, as far as it is good; collective.

    The rays are the small displacements that random loads cause, K(0)⁻¹ ξ with normal ξ, each with
    both signs: what a soft body does first. Each goes on in steps until the error of the force
    exceeds the tolerance, at most to half of the body's size. Forces are measured by the energy
    √(fᵀ K(0)⁻¹ f) of what they would cause, which does not depend on how coordinates are scaled.

    Args:
        solid: body.
        law: to be judged.
        shapes: U (r, n, 3) that it was made of.
        tolerance: accepted relative error of the force [-].
        rays: number of random loads; each costs up to 50 assemblies.
        seed: of the random loads.

    Raises:
        DefoError: ``tolerance`` or ``rays`` is not positive, or the shapes are not the body's.
    """
    if not 0.0 < tolerance < np.inf:
        raise DefoError(f"tolerance must be positive, a relative error such as 0.01: {tolerance!r}")
    if not rays >= 1:
        raise DefoError(f"rays must be 1 or more, got {rays!r}")
    direct = DirectForce(solid, shapes)
    softness = _softness(law.stiffness(np.zeros(direct.size)))
    unit = _rays(shapes, softness, rays, seed)
    directions = np.concatenate([unit, -unit])
    amplitudes = float(np.ptp(solid.points, axis=0).max()) * np.geomspace(_FROM, _TO, _COUNT)
    errors = np.full((len(directions), _COUNT), np.nan)
    for direction, along in zip(directions, errors, strict=True):
        for place, amplitude in enumerate(amplitudes):
            along[place] = _error(law, direct, amplitude * direction, softness)
            if not along[place] <= tolerance:
                break
    good = (errors <= tolerance).all(axis=0)
    reached = int(np.argmin(good)) if not good.all() else _COUNT
    return ForceRange(
        directions=directions,
        amplitudes=amplitudes,
        errors=errors,
        tolerance=float(tolerance),
        reach=float(amplitudes[reached - 1]) if reached else 0.0,
    )


def measure_error(
    solid: Solid, law: ForceLaw, shapes: ArrayLike, *, amplitude: float = 0.1, seed: int = 0
) -> float:
    """Error of a law's force [-], as by `measure_range`, at one point of one ray; collective.

    Args:
        solid: body.
        law: to be judged.
        shapes: U (r, n, 3) that it was made of.
        amplitude: largest nodal displacement as a part of the body's size.
        seed: of the random load.
    """
    direct = DirectForce(solid, shapes)
    softness = _softness(law.stiffness(np.zeros(direct.size)))
    (unit,) = _rays(shapes, softness, 1, seed)
    size = float(np.ptp(solid.points, axis=0).max())
    return _error(law, direct, amplitude * size * unit, softness)


def _rays(shapes: ArrayLike, softness: Array, count: int, seed: int) -> Array:
    """Answers q (count, r) to random loads, at which the farthest node has moved by 1 m."""
    fields = np.asarray(shapes, dtype=np.float64)
    loads = np.random.default_rng(seed).standard_normal((count, len(fields)))
    answers = loads @ softness @ softness.T
    farthest = [np.linalg.norm(np.tensordot(q, fields, 1), axis=1).max() for q in answers]
    return np.asarray(answers / np.array(farthest)[:, None])


def _softness(stiffness: Array) -> Array:
    """W (r, k) with W Wᵀ = K⁻¹, rigid motions left out."""
    values, vectors = np.linalg.eigh(stiffness)
    kept = values > _RIGID * values[-1]
    return np.asarray(vectors[:, kept] / np.sqrt(values[kept]))


def _error(law: ForceLaw, direct: DirectForce, q: Array, softness: Array) -> float:
    with np.errstate(all="ignore"):
        wanted = direct.force(q)
        apart = (law.force(q) - wanted) @ softness
        error = np.linalg.norm(apart) / np.linalg.norm(wanted @ softness)
    return float(error) if np.isfinite(error) else np.inf
