"""Bases of displacements from modes, from modal derivatives and from example motions."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.free_motions import free_motions
from fenics_defo.analysis.phases import Phases
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.basis import Basis
from fenics_defo.reduction.body_fields import (
    checked_fields,
    checked_state,
    elastic_modes,
    own_columns,
)
from fenics_defo.reduction.body_frame import in_body_frame
from fenics_defo.reduction.cut import check_cut, checked_size, chosen_basis, orthonormal_basis
from fenics_defo.reduction.derivatives import modal_derivatives
from fenics_defo.reduction.examples import Snapshots, example_motion
from fenics_defo.reduction.mass_space import without
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]

# Largest displacement of the first mode, over the body's length, at which derivatives are weighed.
_BENT = 0.2


def linear_basis(solid: Solid, modes: Modes, size: int | None = None) -> Basis:
    """The first vibration modes that are no rigid motions.

    Collective; the same result on each rank.

    Args:
        solid: body.
        modes: its modes.
        size: number r of columns; all elastic modes if not given.

    Returns:
        mass-orthonormal modes, ascending frequencies.

    Raises:
        DefoError: there are not as many modes, or they are not this body's.
    """
    _, shapes = elastic_modes(solid, modes)
    count = checked_size(len(shapes) if size is None else size, len(shapes), "elastic modes")
    columns = own_columns(solid, shapes[:count])
    origin = {"modes": count, "highest_hz": float(modes.frequencies[modes.rigid_modes + count - 1])}
    return orthonormal_basis(solid, columns, "linear", origin=origin)


def modal_derivative_basis(
    solid: Solid,
    modes: Modes,
    size: int | None = None,
    *,
    share: float | None = None,
    displacement: Array | None = None,
    derivatives: Array | None = None,
    amplitude: float | None = None,
    phases: Phases | None = None,
) -> Basis:
    """Principal components of modes and of their derivatives, weighted by frequency.

    The candidates are (λ₁/λ_i) ψ_i and a λ₁²/(λ_i λ_j) Φ_ij, i ≤ j: what the body does under a
    modal load of the same size on each mode. The basis holds those r directions that miss least
    of them in the norm √(uᵀ M u). Source: Barbič and James, Real-time subspace integration for
    St. Venant-Kirchhoff deformable models, ACM Transactions on Graphics 24(3), 2005, section 4.
    Collective; the same result on each rank.

    Args:
        solid: body.
        modes: k of its modes, rigid ones in front if it is free; these are left out.
        size: number r of columns; or, with ``share``, the most of them.
        share: part of the candidates' Σ σ² that is to be kept [-], instead of, or within ``size``.
        displacement: (n, 3) [m] of the equilibrium that the modes are about; rest if not given.
        derivatives: what `modal_derivatives` gave for these modes; computed if not given.
        amplitude: a, the coordinate of the first mode at which modes and derivatives have their
            weights [kg^1/2 m]. Larger ones weigh the derivatives more. If not given, the one at
            which that mode moves a point by a fifth of the body's length, so that the basis does
            not depend on units; 1 gives the weights of Barbič and James.
        phases: stopwatch of `modal_derivatives`, and "components".

    Returns:
        mass-orthonormal, with the singular values of all candidates.

    Raises:
        DefoError: ``size`` or ``share`` are out of range or both missing, or the modes not this
            body's.
        EigenSolveError, SolverError: those of `modal_derivatives`.
    """
    check_cut(size, share)
    if amplitude is not None and not 0.0 < amplitude < np.inf:
        raise DefoError(
            f"amplitude must be positive [kg^1/2 m], got {amplitude!r}; leave it out for one of "
            "the body's size"
        )
    phases, displacement = phases or Phases(), checked_state(solid, displacement)
    values, shapes = elastic_modes(solid, modes)
    if derivatives is None:
        derivatives = modal_derivatives(solid, modes, displacement=displacement, phases=phases)
    derivatives = checked_fields(solid, derivatives, "derivatives")
    pairs = len(shapes) * (len(shapes) + 1) // 2
    if len(derivatives) != pairs:
        raise DefoError(
            f"{len(shapes)} modes have {pairs} derivatives, got {len(derivatives)}; pass what "
            "modal_derivatives returned for the same modes"
        )
    if amplitude is None:
        farthest = float(np.linalg.norm(shapes[0], axis=1).max())
        amplitude = _BENT * float(np.ptp(solid.points, axis=0).max()) / farthest
    with phases("components"):
        return chosen_basis(
            solid,
            _weighted(solid, values, shapes, derivatives, amplitude),
            size,
            share,
            "modal-derivatives",
            motions=own_columns(solid, free_motions(solid, displacement)),
            origin={
                "modes": len(shapes),
                "derivatives": pairs,
                "amplitude": float(amplitude),
                "about": "rest" if displacement is None else "a deformed state",
            },
        )


def _weighted(
    solid: Solid, values: Array, shapes: Array, derivatives: Array, amplitude: float
) -> Array:
    """Modes and derivatives as weighted columns (owned dofs, k + k(k + 1)/2)."""
    count, weight = len(shapes), values[0] / values
    first, second = np.triu_indices(count)
    columns = np.empty((3 * solid.nodes.owned, count + len(first)), order="F")
    columns[:, :count] = own_columns(solid, shapes) * weight
    columns[:, count:] = own_columns(solid, derivatives)
    columns[:, count:] *= amplitude * weight[first] * weight[second]
    return columns


def snapshot_basis(
    solid: Solid, snapshots: Snapshots, size: int | None = None, *, share: float | None = None
) -> Basis:
    """Principal components of an example motion, in the norm √(uᵀ M u).

    Of a body that is free to fly the rigid motion is taken out of each snapshot first, however
    large: the basis is for its deformation. Collective; the same result on each rank.

    Args:
        solid: body.
        snapshots: displacements (s, n, 3) [m], nodes in the order of its file; or states,
            equilibria or motions, of which the displacements are taken; or the folder of a run of
            ``fenics-defo simulate``.
        size: number r of columns; or, with ``share``, the most of them.
        share: part of the snapshots' Σ σ² that is to be kept [-], instead of, or within ``size``.

    Returns:
        mass-orthonormal, with the singular values of all snapshots.

    Raises:
        DefoError: ``size`` or ``share`` are out of range or both missing, or the snapshots do not
            fit the body.
        FileFormatError: the folder's series is missing or damaged.
    """
    check_cut(size, share)
    fields = checked_fields(solid, example_motion(solid, snapshots), "snapshots")
    motions = free_motions(solid)
    if len(motions) == 6 and not solid.held.any():
        fields = in_body_frame(solid.points, solid.lumped_mass(), fields)
    else:
        motions = motions[:0]
    known = own_columns(solid, motions)
    return chosen_basis(
        solid,
        without(solid, known, own_columns(solid, fields)),
        size,
        share,
        "snapshots",
        motions=known,
        origin={"snapshots": len(fields)},
    )
