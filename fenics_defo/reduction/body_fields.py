"""Displacement fields in the user's order and over a rank's own part; what a body can take."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]

# Values at held components, relative to the largest of their field, that are round-off.
_ROUND_OFF = 1e-9


def own_columns(solid: Solid, shapes: Array) -> Array:
    """Fields (s, n, 3) over the components that this rank owns: (owned dofs, s), Fortran order."""
    owned = solid.nodes.rows[: solid.nodes.owned]
    return shapes[:, owned].reshape(len(shapes), 3 * len(owned)).T


def gathered(solid: Solid, columns: Array) -> Array:
    """The fields (s, n, 3) of columns (owned dofs, s), on each rank; collective."""
    local = columns.reshape(-1, 3, columns.shape[1])
    return np.ascontiguousarray(np.moveaxis(solid.nodes.gather(local), 2, 0))


def checked_fields(solid: Solid, fields: ArrayLike, what: str) -> Array:
    """Fields (s, n, 3) that the body can take: finite, zero where it is held.

    Args:
        solid: body.
        fields: (s, n, 3), nodes in the user's order.
        what: how the fields are called in an error.

    Returns:
        the fields; exactly zero at held components, interpolated at nodes that the body's
        displacements do not have of their own.

    Raises:
        DefoError: they are not such.
    """
    array, size = np.asarray(fields, np.float64), solid.nodes.size
    if array.ndim != 3 or len(array) == 0 or array.shape[1:] != (size, 3):
        raise DefoError(
            f"{what} must have the shape (r, {size}, 3), r from 1: a displacement of each of this "
            f"body's {size} nodes in the order of its file; got {array.shape}"
        )
    if not np.isfinite(array).all():
        raise DefoError(f"{what} must be finite, got NaN or infinity")
    largest = np.abs(array).max(axis=(1, 2))
    moved = np.abs(array[:, solid.held]).max(axis=1, initial=0.0)
    wrong = np.flatnonzero(~(moved <= _ROUND_OFF * largest))
    if len(wrong):
        raise DefoError(
            f"{what} must be zero where the body is held, but number {wrong[0]} is "
            f"{moved[wrong[0]]:.3g} there; take them from a body that is held alike"
        )
    if not moved.any() and solid.nodes.carried.all():
        return array
    array = np.where(solid.held, 0.0, array)
    if not solid.nodes.carried.all():
        flat = np.moveaxis(array, 0, 2).reshape(size, -1)
        filled = (solid.nodes.corner_weights @ flat).reshape(size, 3, -1)
        array = np.where(solid.nodes.carried[:, None], array, np.moveaxis(filled, 2, 0))
    return array


def checked_state(solid: Solid, displacement: ArrayLike | None) -> Array | None:
    """A displacement (n, 3) [m] that the body can have; None, for rest, stays None.

    Raises:
        DefoError: it cannot.
    """
    if displacement is None:
        return None
    array, shape = np.asarray(displacement, np.float64), solid.points.shape
    if array.shape != shape:
        raise DefoError(
            f"displacement must have the shape {shape}, one row for each of this body's nodes; "
            f"got {array.shape}"
        )
    return checked_fields(solid, array[None], "displacement")[0]


def elastic_modes(solid: Solid, modes: Modes) -> tuple[Array, Array]:
    """The modes that are no rigid motions, if they are modes of this body.

    Returns:
        λ = ω² (k,) [rad²/s²] and shapes (k, n, 3) [kg^-1/2].

    Raises:
        DefoError: they are modes of another body, or all rigid.
    """
    if not isinstance(modes, Modes):
        raise DefoError(
            f"modes must be what linear_modes or load_modes returned, got {type(modes).__name__}; "
            "for fields of your own use basis_from_array"
        )
    if not modes.rigid_modes < modes.size:
        raise DefoError(
            f"all {modes.size} modes are rigid motions, which do not deform the body; compute more"
        )
    shapes = checked_fields(solid, modes.shapes[modes.rigid_modes :], "modes")
    tolerance = 1e-6 * float(np.ptp(solid.points, axis=0).max())
    if not np.abs(modes.points - solid.points).max() <= tolerance:
        raise DefoError(
            "these are modes of another body: its nodes lie elsewhere; compute modes of this one"
        )
    return modes.omega[modes.rigid_modes :] ** 2, shapes
