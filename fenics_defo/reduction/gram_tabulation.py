"""St. Venant-Kirchhoff's energy within a basis, exactly, by one Gram matrix."""

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

from fenics_defo.energy import LinearElastic, Material, StVenantKirchhoff, formula
from fenics_defo.errors import MaterialError
from fenics_defo.fem import Solid
from fenics_defo.fem.field_gradients import region_gradients
from fenics_defo.fem.material_fields import LawRegion
from fenics_defo.reduction.strain_columns import StrainColumns

Array = NDArray[np.float64]

# Entries of the columns of one block: with 6 MB of them BLAS is at its best and they stay in the
# processor's last cache; below so many points it is not. Rows of 512 points, a page long, would
# fall on each other in the first cache.
_ENTRIES = 750_000
_FEWEST, _MOST = 64, 480


@dataclass(frozen=True, slots=True)
class EnergyDerivatives:
    """Derivatives at rest of a body's energy with respect to q, u = Σ q_i U_i.

    Args:
        second: (r, r), ∂²/∂q_i∂q_j.
        third: (s, r), ∂³/∂q_i∂q_j∂q_k, a row a pair i ≤ j in row-major order, s = r (r + 1)/2.
        fourth: (s, s), ∂⁴/∂q_i∂q_j∂q_k∂q_l.
    """

    second: Array
    third: Array
    fourth: Array


def strain_derivatives(solid: Solid, fields: Array) -> EnergyDerivatives:
    """All derivatives of a body of St. Venant-Kirchhoff's and linear laws; collective.

    E(q) = Σ q_i e_i + ½ Σ q_i q_j n_ij is quadratic in q (see `StrainColumns`), and the energy is
    ½ ∫ E : C : E dX, so that with G the Gram matrix of the e_i and n_ij under ∫ · : C : · dX

        ∂²:  G(e_i, e_j)
        ∂³:  G(e_i, n_jk) + G(e_j, n_ik) + G(e_k, n_ij)
        ∂⁴:  G(n_ij, n_kl) + G(n_ik, n_jl) + G(n_il, n_jk).

    It is exact as far as the body's own quadrature goes: element, order and materials may be any.
    The Gram matrix, a sum over blocks of points and over ranks, takes six columns' products a
    point: 1.5 r⁴ operations. (Barbic and James, ACM TOG 24(3), 2005, have the polynomial.)

    Args:
        solid: body.
        fields: (r, d, 3) U_i at this rank's nodes, ghosts included.

    Raises:
        MaterialError: a law whose energy is no polynomial of fourth degree.
    """
    check_polynomial(solid)
    r = len(fields)
    gram = np.zeros((r + r * (r + 1) // 2,) * 2, order="F")
    for region in solid.fields.regions:
        linear = _key(region) == _LINEAR
        part = _region_gram(solid, region, fields, pairs=not linear)
        gram[: len(part), : len(part)] += part
    total = np.empty_like(gram)
    solid.comm.Allreduce(gram, total)
    # The upper triangle alone is filled.
    total += np.triu(total, 1).T
    return derivatives_of_gram(total, r)


def _region_gram(solid: Solid, region: LawRegion, fields: Array, *, pairs: bool) -> Array:
    """Upper triangle of this rank's Gram matrix of one law's cells, (r, r) without pairs."""
    r = len(fields)
    count = r + (r * (r + 1) // 2 if pairs else 0)
    points = min(max(_ENTRIES // (6 * count), _FEWEST), _MOST)
    gram = np.zeros((count, count), order="F")
    columns: StrainColumns | None = None
    blocks = region_gradients(
        solid.space, region, fields, degree=solid.degrees.energy, points=points
    )
    for block in blocks:
        if columns is None:  # the first block is the largest
            columns = StrainColumns(r, len(block.weights), pairs=pairs)
        lmbda, mu = (block.at_points(region.parameters[name]) for name in ("lmbda", "mu"))
        A = columns(block.gradients, block.weights, lmbda, mu)
        gram = dsyrk(1.0, A.T, beta=1.0, c=gram, trans=1, overwrite_c=1)
    return gram


def derivatives_of_gram(gram: Array, r: int) -> EnergyDerivatives:
    """Derivatives of the energy whose Gram matrix is given, see `strain_derivatives`.

    Args:
        gram: of the r e_i and the pairs' n_ij, complete and symmetric.
        r: number of fields.
    """
    i, j = np.triu_indices(r)
    pair = np.empty((r, r), np.intp)
    pair[i, j] = pair[j, i] = np.arange(len(i))
    mixed, quartic = gram[:r, r:], gram[r:, r:]
    k = np.arange(r)
    third = mixed[:, pair[i, j]][k, :].T.copy()
    third += mixed[i[:, None], pair[j][:, k]]
    third += mixed[j[:, None], pair[i][:, k]]
    fourth = np.array(quartic, order="C")
    for row in range(len(i)):  # a row at a time: index arrays of all would be larger than it
        a, b = pair[i[row]], pair[j[row]]
        fourth[row] += quartic[a[i], b[j]]
        fourth[row] += quartic[a[j], b[i]]
    return EnergyDerivatives(gram[:r, :r].copy(), third, fourth)


def check_polynomial(solid: Solid) -> None:
    """Check that a body's energy is a sum of squares of polynomials of q; collective.

    Raises:
        MaterialError: it is not.
    """
    unstable = 0
    for region in solid.fields.regions:
        if _key(region) not in (_EXACT, _LINEAR):
            raise MaterialError(
                "a cubic force is exact for st-venant-kirchhoff and linear laws alone, and the "
                f"body has cells of {type(region.material).__name__}; take "
                'force = "taylor", its expansion about rest (small strains), or "cubature"'
            )
        lmbda, mu = (region.parameters[name].x.array for name in ("lmbda", "mu"))
        cells = region.parameters["mu"].function_space.dofmap.list[region.cells, 0]
        stable = (mu[cells] > 0.0) & (3.0 * lmbda[cells] + 2.0 * mu[cells] >= 0.0)
        unstable += int(np.count_nonzero(~stable))
    if solid.comm.allreduce(unstable):
        raise MaterialError(
            "a cubic force needs mu > 0 and a bulk modulus lmbda + 2/3 mu of at least 0 in all "
            'cells, which this body\'s law does not have; take force = "taylor", or other constants'
        )


def _key(region: LawRegion) -> Hashable:
    return formula(region.material) if isinstance(region.material, Material) else None


_EXACT = formula(StVenantKirchhoff(young=1.0, poisson=0.0, density=1.0))
_LINEAR = formula(LinearElastic(young=1.0, poisson=0.0, density=1.0))
