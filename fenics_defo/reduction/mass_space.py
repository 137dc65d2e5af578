"""Displacement fields with the consistent mass as their inner product, spread over ranks.

Fields are columns over the components that a rank owns, (owned dofs, s), zero where held. All is
collective.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from fenics_defo.analysis.spectrum import align_clusters, quadratic_fields
from fenics_defo.fem import Solid

Array = NDArray[np.float64]

# Singular values below this part of the largest are round-off.
_RANK = 1e-12
# Singular values closer than this, relative to themselves, are one: their vectors are aligned.
_SAME = 1e-9


def gram(solid: Solid, left: Array, right: Array | None = None) -> Array:
    """leftᵀ M right (l, r), right = left if it is not given; then symmetric."""
    given = left if right is None else right
    product = solid.comm.allreduce(left.T @ solid.assembly.mass.multiply(given))
    return np.asarray(product if right is not None else 0.5 * (product + product.T))


def orthonormal_factors(solid: Solid, columns: Array) -> tuple[Array, Array, Array]:
    """Q, L and R with columns = Q R and Qᵀ M Q = L Lᵀ of a small condition, whatever the columns.

    By Householder's method for columns weighted with the root of the lumped mass, rank by rank and
    then for the ranks' triangles, which no near dependence of columns harms. Between the lumped and
    the consistent mass lies a matrix of a condition of about ten: what is left can be done by
    Cholesky's factor without a loss of digits. Q L⁻ᵀ is orthonormal in M.

    Args:
        solid: body.
        columns: (owned dofs, s).

    Returns:
        Q (owned dofs, m), L (m, m) lower triangular and R (m, s), m the smaller of s and of the
        body's free components.
    """
    free = ~solid.assembly.held[: solid.assembly.owned].ravel()
    mass = np.repeat(solid.assembly.lumped_mass()[: solid.assembly.owned], 3)[free]
    root = np.sqrt(mass)[:, None]
    weighted = np.asfortranarray(root * columns[free])
    inner, triangle = linalg.qr(weighted, mode="economic", overwrite_a=True, check_finite=False)
    if solid.comm.size > 1:
        triangles = solid.comm.allgather(triangle)
        start = sum(len(other) for other in triangles[: solid.comm.rank])
        outer, triangle = linalg.qr(np.vstack(triangles), mode="economic", check_finite=False)
        inner = inner @ outer[start : start + inner.shape[1]]
    Q = np.zeros((len(free), inner.shape[1]), order="F")
    Q[free] = inner / root
    return Q, np.linalg.cholesky(gram(solid, Q)), triangle


@dataclass(frozen=True, slots=True)
class Principal:
    """Principal components of some fields, those of equal values made unique.

    Args:
        factor: Q (owned dofs, m).
        turn: (m, rank), by which the components are combinations of Q.
        values: all singular values (m,), descending.
    """

    factor: Array
    turn: Array
    values: Array

    @property
    def rank(self) -> int:
        """How many singular values are more than round-off."""
        return self.turn.shape[1]

    def vectors(self, count: int) -> Array:
        """The first components (owned dofs, count)."""
        return self.factor @ self.turn[:, :count]

    def share(self, count: int) -> float:
        """What part of the sum of squares the first ``count`` components hold [-]."""
        squares = self.values**2
        return float(squares[:count].sum() / squares.sum())

    def smallest(self, share: float) -> int:
        """The least number of components that hold a share; no more than ``rank``."""
        tails = np.append(np.cumsum(self.values[::-1] ** 2)[::-1], 0.0)
        enough = tails <= (1.0 - share) * tails[0]
        return min(max(int(np.argmax(enough)), 1), self.rank)


def principal_components(solid: Solid, columns: Array) -> Principal:
    """Principal components of columns (owned dofs, s) in the inner product of M.

    With Q, L and R of `orthonormal_factors` and Lᵀ R = W Σ Vᵀ they are Q L⁻ᵀ W: the squares of the
    columns' products, which have half of their digits, appear nowhere.
    """
    Q, L, R = orthonormal_factors(solid, columns)
    W, values, _ = linalg.svd(L.T @ R, full_matrices=False)
    rank = int(np.count_nonzero(values > _RANK * values.max(initial=0.0)))
    turn = linalg.solve_triangular(L, W[:, :rank], trans="T", lower=True)
    turn = turn @ _alignment(solid, Q, turn, values[:rank])
    return Principal(Q, turn, values)


def _alignment(solid: Solid, Q: Array, turn: Array, values: Array) -> Array:
    """Rotation (m, m) of the vectors of equal values, which round-off else would choose."""
    owned, points = solid.assembly.owned, solid.points
    low, high = points.min(axis=0), points.max(axis=0)
    place = (points - 0.5 * (low + high)) / (0.5 * float(np.max(high - low)))
    fields = quadratic_fields(solid.nodes.scatter(place)[:owned]).reshape(30, -1).T
    fields[solid.assembly.held[:owned].ravel()] = 0.0
    lengths = np.sqrt(np.diag(gram(solid, fields)))
    fields /= np.where(lengths > 0.0, lengths, 1.0)
    projections = turn.T @ gram(solid, Q, fields)
    backwards = align_clusters(values[::-1], projections[::-1], rtol=np.full(len(values), _SAME))
    return backwards[::-1, ::-1]


def without(solid: Solid, known: Array, columns: Array) -> Array:
    """Columns less their parts in the span of known ones (owned dofs, k), which may be none."""
    for _ in range(2):  # the second time removes what the first one's round-off left
        if known.shape[1]:
            inner = np.linalg.solve(gram(solid, known), gram(solid, known, columns))
            columns = columns - known @ inner
    return columns
