"""The integrals of mass of a free-flying body, from its finite elements."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.runtime.floating.frame import PAIRS, FloatingFrame

Array = NDArray[np.float64]

# Share of a shape's mass that must be left once rigid rotations are taken out of the shapes.
_LEAST_SHARE = 1e-8


def inertia_integrals(solid: Solid, shapes: Array) -> FloatingFrame:
    """Integrals of mass of a free-flying body and its shapes, with the consistent mass.

    All of them are entries of one Gram matrix F^T m F, where the columns of F are the nodes'
    places, and the components of the shapes. Collective; the same numbers on each rank.

    Args:
        solid: body that nothing holds.
        shapes: (r, n, 3) displacements, nodes in the order of the user's file, for instance
            ``basis.shapes``; r may be 0 for a rigid body.

    Returns:
        the record for ``runtime.floating``.

    Raises:
        DefoError: the body is held somewhere, the shapes do not fit it or are not finite, or a
            combination of them is a rigid motion, which the frame has already.
    """
    given = np.asarray(shapes, dtype=np.float64)
    if given.ndim != 3 or given.shape[1:] != (solid.nodes.size, 3):
        raise DefoError(
            f"shapes of this body have the shape (r, {solid.nodes.size}, 3), got {given.shape}"
        )
    if not np.isfinite(given).all():
        raise DefoError("shapes must be finite, got NaN or infinity")
    held = int(np.count_nonzero(solid.held))
    if held:
        raise DefoError(
            f"{held} displacement components of this body are held, so it cannot fly; leave out "
            "its constraints, or use a model without a floating frame"
        )
    frame = _frame(solid, given)
    _check_no_rigid_motion(frame)
    return frame


def _frame(solid: Solid, shapes: Array) -> FloatingFrame:
    """The record from Gram matrices over this rank's own nodes."""
    nodes, mass = solid.nodes, solid.assembly.mass
    own = nodes.rows[: nodes.owned]
    places = nodes.points[own] - 0.5 * (nodes.points.min(axis=0) + nodes.points.max(axis=0))
    weights = mass.apply(np.ones((nodes.owned, 1)))[:, 0]
    # Columns of the displacements' components, (own nodes, 3 r), all shapes of x first.
    r = len(shapes)
    bent = np.ascontiguousarray(shapes[:, own].transpose(1, 2, 0)).reshape(nodes.owned, 3 * r)
    fields = np.hstack([places, bent])
    moments = np.asarray(solid.comm.allreduce(np.append(weights @ fields, weights.sum())))
    total, means = float(moments[-1]), moments[:-1] / moments[-1]
    fields -= means
    gram = np.asarray(solid.comm.allreduce(fields.T @ mass.apply(fields)))
    gram = 0.5 * (gram + gram.T)
    centre = 0.5 * (nodes.points.min(axis=0) + nodes.points.max(axis=0)) + means[:3]
    linear = gram[:3, 3:].reshape(3, 3, r)
    blocks = gram[3:, 3:].reshape(3, r, 3, r)
    return FloatingFrame(
        mass=total,
        centre=centre,
        second_moment=gram[:3, :3],
        mean=means[3:].reshape(3, r),
        linear=linear,
        quadratic=np.stack([blocks[a, :, b] for a, b in PAIRS]),
    )


def _check_no_rigid_motion(frame: FloatingFrame) -> None:
    """Refuse shapes some combination of which is a translation or a small rotation."""
    if not frame.size:
        return
    size = np.sqrt(np.diagonal(frame.shape_mass) + frame.mass * (frame.mean**2).sum(axis=0))
    if not (size > 0.0).all():
        raise DefoError(f"shape {int(np.argmin(size))} of a free body is zero; leave it out")
    moment = frame.turning_moment
    left = frame.shape_mass - moment.T @ np.linalg.solve(frame.inertia, moment)
    least = float(np.linalg.eigvalsh(left / np.outer(size, size))[0])
    if not least > _LEAST_SHARE:
        raise DefoError(
            "a combination of the shapes is a rigid motion (what deforms the body has "
            f"{max(least, 0.0):.2g} of its mass), and the floating frame moves rigidly by itself; "
            "take the rigid motions out of the basis"
        )
