"""Bases of fields that are given: the user's own, and those of other bases."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.basis import Basis, Plain
from fenics_defo.reduction.body_fields import checked_fields, own_columns
from fenics_defo.reduction.cut import orthonormal_basis
from fenics_defo.reduction.mass_space import (
    gram,
    orthonormal_factors,
    principal_components,
    without,
)

Array = NDArray[np.float64]

# Columns that are dependent to this part of their length make a mass that cannot be inverted.
_DEPENDENT = 1e-7
# What is left of a unit field outside a basis that it is joined to, for it to count.
_NEW = 1e-6


def join(solid: Solid, *bases: Basis) -> Basis:
    """One basis of the span of several.

    The first one's columns come first, as they are if they are mass-orthonormal; of each other one
    come the principal components of what the earlier ones lack. Collective.

    Args:
        solid: body.
        bases: of this body; two or more.

    Returns:
        mass-orthonormal.

    Raises:
        DefoError: fewer than two bases, or one of another body.
    """
    if len(bases) < 2:
        raise DefoError(f"join takes two or more bases, got {len(bases)}")
    columns = np.empty((3 * solid.assembly.owned, 0))
    for basis in bases:
        shapes = checked_fields(solid, basis.shapes, f"the basis of {basis.kind!r}")
        fields = own_columns(solid, shapes)
        if not columns.size and basis.is_orthonormal:
            columns = fields
            continue
        fields = fields / np.sqrt(np.diag(gram(solid, fields)))
        rest = without(solid, columns, fields) if columns.shape[1] else fields
        found = principal_components(solid, rest)
        new = found.vectors(int(np.count_nonzero(found.values > _NEW)))
        columns = np.hstack([columns, without(solid, columns, new)])
    origin: dict[str, Plain] = {
        "kinds": tuple(basis.kind for basis in bases),
        "sizes": tuple(b.size for b in bases),
    }
    return orthonormal_basis(solid, columns, "joined", origin=origin)


def basis_from_array(solid: Solid, shapes: ArrayLike) -> Basis:
    """Fields of the user's, kept as given: the reduced mass is then a full matrix.

    Collective; the same result on each rank.

    Args:
        solid: body.
        shapes: (r, n, 3) independent fields of any unit, nodes in the order of the body's file,
            zero where it is held.

    Returns:
        a basis with these columns.

    Raises:
        DefoError: wrong shape, not finite, not zero at held components, or dependent.
    """
    fields = checked_fields(solid, shapes, "shapes")
    columns = own_columns(solid, fields)
    mass = gram(solid, columns)
    lengths = np.sqrt(np.diag(mass))
    if not (lengths > 0.0).all():
        zero = int(np.argmin(lengths))
        raise DefoError(f"shapes must not be zero everywhere, but number {zero} is; leave it out")
    _check_independent(solid, columns / lengths)
    return Basis(shapes=fields.copy(), mass=mass, kind="given")


def _check_independent(solid: Solid, columns: Array) -> None:
    """Refuse unit columns of which one is nearly a combination of others."""
    _, L, R = orthonormal_factors(solid, columns)
    _, values, right = np.linalg.svd(L.T @ R)
    if len(values) == columns.shape[1] and values[-1] > _DEPENDENT * values[0]:
        return
    weights = np.abs(right[-1])
    together = np.flatnonzero(weights > 1e-3 * weights.max())
    raise DefoError(
        f"shapes must be independent, but number {int(np.argmax(weights))} is a combination of "
        f"others (those that hang together, from 0: {', '.join(map(str, together))}); leave one of "
        "them out"
    )
