"""Where the list of principal components is cut, and the record of what is kept."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.spectrum import signs
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.basis import Basis, Plain
from fenics_defo.reduction.body_fields import gathered, own_columns
from fenics_defo.reduction.mass_space import gram, principal_components, without

Array = NDArray[np.float64]


def check_cut(size: int | None, share: float | None) -> None:
    """Refuse a size or a share that says nothing.

    Raises:
        DefoError: both are missing, or one is out of its range.
    """
    if size is None and share is None:
        raise DefoError("say how large the basis shall be: size=r columns, or share=0.999 of Σ σ²")
    if size is not None:
        checked_size(size)
    if share is not None and not 0.0 < share <= 1.0:
        raise DefoError(f"share must be above 0 and at most 1, got {share!r}; 0.999 is usual")


def checked_size(size: int, limit: int | None = None, what: str = "") -> int:
    """The size as a whole number from 1 to a limit.

    Raises:
        DefoError: it is none.
    """
    if isinstance(size, bool) or not isinstance(size, int | np.integer) or not size >= 1:
        raise DefoError(f"size must be a whole number from 1, got {size!r}")
    if limit is not None and size > limit:
        raise DefoError(f"size must be at most {limit}, the number of {what}, got {size}")
    return int(size)


def chosen_basis(
    solid: Solid,
    columns: Array,
    size: int | None,
    share: float | None,
    kind: str,
    *,
    motions: Array,
    origin: Mapping[str, Plain],
) -> Basis:
    """The basis of the first principal components of candidates (owned dofs, s); collective.

    Where they are small beside the first one, so is what round-off leaves in the candidates of
    ``motions`` (owned dofs, k), rigid ones, which have no place in a basis: it is taken out again.

    Raises:
        DefoError: the candidates are all zero, or span less than ``size``.
    """
    found = principal_components(solid, columns)
    if found.rank == 0:
        raise DefoError("all fields are zero, nothing spans a basis; give a motion that deforms")
    if share is None:
        assert size is not None
        count = checked_size(size, found.rank, "independent candidates")
    else:
        count = min(found.smallest(share), found.rank if size is None else size)
    return orthonormal_basis(
        solid,
        without(solid, motions, found.vectors(count)),
        kind,
        values=found.values,
        kept=found.share(count),
        origin=origin,
    )


def orthonormal_basis(
    solid: Solid,
    columns: Array,
    kind: str,
    *,
    values: Array | None = None,
    kept: float | None = None,
    origin: Mapping[str, Plain],
) -> Basis:
    """The record of columns that are orthonormal in M but for small errors, which it mends.

    Each changes as little as can be; the largest component of each is made positive. Collective.
    """
    weights, vectors = np.linalg.eigh(gram(solid, columns))
    shapes = gathered(solid, columns @ ((vectors / np.sqrt(weights)) @ vectors.T))
    shapes *= signs(shapes)[:, None, None]
    shapes += 0.0  # no negative zeros: the bytes of a file are those of the numbers
    return Basis(
        shapes=shapes,
        mass=gram(solid, own_columns(solid, shapes)),
        kind=kind,
        singular_values=values,
        kept=kept,
        origin=origin,
    )
