"""Springs between the corners of cells, as stiff as an isotropic solid."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]
type Integers = NDArray[np.integer]

# Pairs of corners of a cell, in the order of DOLFINx, and the weight of each pair's springs.
_TETRAHEDRON = {(0, 1): 1.0, (0, 2): 1.0, (0, 3): 1.0, (1, 2): 1.0, (1, 3): 1.0, (2, 3): 1.0}
_EDGES = "01 23 45 67 02 13 46 57 04 15 26 37"
_FACE_DIAGONALS = "03 12 47 56 05 14 27 36 06 24 17 35"
_HEXAHEDRON = {
    **{(int(pair[0]), int(pair[1])): 0.1 for pair in _EDGES.split()},
    **{(int(pair[0]), int(pair[1])): 0.4 for pair in _FACE_DIAGONALS.split()},
}


@dataclass(frozen=True, slots=True)
class Springs:
    """Springs between nodes; ψ of one is k/2 (l − L)² with l = |x_b − x_a|.

    Args:
        ends: rows (e, 2) of the points that each joins.
        length: length at rest L (e,) [m].
        stiffness: k (e,) [N/m].
    """

    ends: NDArray[np.int64]
    length: Array
    stiffness: Array


def cell_springs(points: Array, cells: Integers, young: Array | float) -> Springs:
    """Springs of a mesh of tetrahedra or of hexahedra.

    k = Σ_c w E_c V_c / L² over the cells c that hold the pair; w = 1 for the 6 edges of a
    tetrahedron, 1/10 for the 12 edges of a hexahedron and 2/5 for the 12 diagonals of its faces.

    Under a uniform small strain ε springs of directions n store Σ k L² (n·ε n)²/2. The mean of
    (n·ε n)² over all directions is ((tr ε)² + 2 ε:ε)/15, so that the network is the isotropic solid
    with λ = μ = Σ k L²/(15 V); with E = 5μ/2 then Σ k L² = 6 E V, which the weights satisfy in each
    cell. Poisson's ratio is 1/4, as always where central forces balance (Cauchy). A cube has these
    moduli in all directions; tetrahedra only on the mean over their edges' directions, so that a
    regular mesh is stiffer along some. Any cell has the right bulk modulus. For tetrahedra the
    formula is that of Van Gelder, Approximate simulation of elastic membranes by triangulated
    spring meshes, 1998; Lloyd, Szekely and Harders, Identification of spring parameters for
    deformable object simulation, 2007, find 4 % less for a regular one.

    Limits: small strains and moderate ones; a spring has no volume, so that a cell may turn inside
    out without a force that turns it back; slivers give their long edges soft springs and their
    short ones stiff springs, which bounds the step of explicit integrators.

    Args:
        points: (n, 3) corner nodes at rest [m].
        cells: (c, 4) or (c, 8) rows of ``points``, corners in the order of DOLFINx.
        young: Young's modulus [Pa], a number or (c,).

    Returns:
        one spring for each pair of nodes. Springs of a part of the cells have that part's share of
        the stiffness: those of all parts together are the springs of the whole.
    """
    weights = _TETRAHEDRON if cells.shape[1] == 4 else _HEXAHEDRON
    pairs = np.array(list(weights))
    ends = np.sort(cells[:, pairs].astype(np.int64), axis=2)  # (c, p, 2)
    volume = _volumes(points[cells])
    share = np.multiply.outer(young * volume, np.array(list(weights.values())))
    codes = ends[..., 0] * len(points) + ends[..., 1]
    distinct, which = np.unique(codes, return_inverse=True)
    total = np.bincount(which.ravel(), weights=share.ravel(), minlength=len(distinct))
    first, second = np.divmod(distinct, max(len(points), 1))
    length = np.linalg.norm(points[second] - points[first], axis=1)
    return Springs(np.column_stack((first, second)), length, total / length**2)


def _volumes(corners: Array) -> Array:
    """Volumes (c,) of cells of straight edges with corners (c, 4 or 8, 3)."""
    if corners.shape[1] == 4:
        edges = corners[:, 1:] - corners[:, :1]
        return np.abs(np.linalg.det(edges)) / 6.0
    x = corners.reshape(-1, 2, 2, 2, 3)  # axes: z, y, x of the reference cube
    gauss = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    total = np.zeros(len(corners))
    for a in gauss:
        for b in gauss:
            for c in gauss:
                weights = np.array([[1 - a, a], [1 - b, b], [1 - c, c]])
                slopes = np.array([-1.0, 1.0])
                jacobian = np.stack(
                    [
                        np.einsum("nzyxd,z,y,x->nd", x, weights[0], weights[1], slopes),
                        np.einsum("nzyxd,z,y,x->nd", x, weights[0], slopes, weights[2]),
                        np.einsum("nzyxd,z,y,x->nd", x, slopes, weights[1], weights[2]),
                    ],
                    axis=1,
                )
                total += np.linalg.det(jacobian) / 8.0
    return np.abs(total)
