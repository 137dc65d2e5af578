"""Any energy within a basis up to the fourth order about rest."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dgemm

from fenics_defo.energy import Invertible, Material
from fenics_defo.errors import MaterialError
from fenics_defo.fem import Solid
from fenics_defo.fem.field_gradients import GradientBlock, region_gradients
from fenics_defo.fem.material_fields import LawRegion
from fenics_defo.reduction.gram_tabulation import EnergyDerivatives
from fenics_defo.reduction.rest_tensors import PAIRS, RestDerivatives, RestTensors

Array = NDArray[np.float64]

# Entries of the products of gradients of one block, and the fewest points that make one.
_ENTRIES = 1_500_000
_FEWEST = 16
_STRESS = 1e-8  # accepted at rest, relative to the largest modulus


def rest_derivatives(solid: Solid, fields: Array) -> EnergyDerivatives:
    """Derivatives at rest of a body's energy up to the fourth; collective.

    With D_i = ∇U_i and A, A', A'' the second to fourth derivatives of ψ(F) at F = I,

        ∂²:  ∫ A : D_i D_j dX,   ∂³:  ∫ A' : D_i D_j D_k dX,   ∂⁴:  ∫ A'' : D_i D_j D_k D_l dX.

    For St. Venant-Kirchhoff these are all that differ from zero; for others they are the beginning
    of a series. Products of two D are columns of 45 rows, which A'' and BLAS multiply: 22 r⁴
    operations a point, fifteen times those of `strain_derivatives`.

    Args:
        solid: body.
        fields: (r, d, 3) U_i at this rank's nodes, ghosts included.

    Raises:
        MaterialError: a law that has no energy in UFL, is stressed at rest, or lacks derivatives.
    """
    r = len(fields)
    s = r * (r + 1) // 2
    sums = _Sums(r)
    problems: list[str] = []
    points = max(_ENTRIES // (45 * s), _FEWEST)
    for region in solid.fields.regions:
        material = _smooth(region)
        derivatives = RestDerivatives(material)
        known: dict[bytes, RestTensors] = {}
        for block in region_gradients(
            solid.space, region, fields, degree=solid.degrees.energy, points=points
        ):
            tensors, row = _tensors(derivatives, region, block, known)
            problem = _problem(material, tensors)
            if problem:
                problems.append(problem)
                break
            sums.add(block, tensors, row)
    found = [problem for each in solid.comm.allgather(problems) for problem in each]
    if found:
        raise MaterialError(found[0])
    return EnergyDerivatives(*(_summed(solid, part) for part in sums.parts))


def _summed(solid: Solid, part: Array) -> Array:
    total = np.empty(part.shape)
    solid.comm.Allreduce(np.ascontiguousarray(part), total)
    return total


def _smooth(region: LawRegion) -> Material:
    """The law, or what an invertible one is near rest, as an energy in UFL."""
    law = region.material.material if isinstance(region.material, Invertible) else region.material
    if not isinstance(law, Material):
        raise MaterialError(
            f"a Taylor model needs an energy in UFL, which {type(law).__name__} does not have; "
            'take force = "direct", "cubature" or "linear", or another law'
        )
    return law


def _tensors(
    derivatives: RestDerivatives,
    region: LawRegion,
    block: GradientBlock,
    known: dict[bytes, RestTensors],
) -> tuple[RestTensors, NDArray[np.intp]]:
    """The tensors of the distinct constants in a block, and which of them each point (p,) has."""
    columns = [block.at_points(field) for field in region.parameters.values()]
    table = np.column_stack(columns) if columns else np.zeros((len(block.weights), 0))
    if table.shape[1] == 0:
        rows, place = table[:1], np.zeros(len(table), np.intp)
    else:
        rows, place = np.unique(table, axis=0, return_inverse=True)
    key = rows.tobytes()
    if key not in known:
        known.clear()  # blocks of equal constants follow each other
        known[key] = derivatives(rows)
    return known[key], place.ravel()


def _problem(material: Material, tensors: RestTensors) -> str:
    """What is wrong with a law at rest; empty if nothing is."""
    name, scale = type(material).__name__, float(np.abs(tensors.second).max())
    stress = float(np.abs(tensors.first).max())
    highest = (tensors.third, tensors.fourth)
    if not all(np.isfinite(part).all() for part in (scale, stress, *highest)):
        return (
            f"the energy of {name} has no finite derivatives up to the fourth at rest (F = I), so "
            'there is no Taylor model of it; take force = "direct" or "cubature"'
        )
    if not stress <= _STRESS * scale:
        return (
            f"the energy of {name} is stressed at rest (F = I), by up to {stress:.3g} Pa: a "
            "reduced model starts from a shape without forces; add a term that cancels the stress, "
            "such as a multiple of ln J"
        )
    return ""


class _Sums:
    """The integrals, point by point."""

    def __init__(self, size: int) -> None:
        self._left, self._right = np.triu_indices(size)
        s = len(self._left)
        self._second = np.zeros((size, size), order="F")
        self._third = np.zeros((s, size), order="F")
        self._fourth = np.zeros((s, s), order="F")

    @property
    def parts(self) -> tuple[Array, Array, Array]:
        """What this rank's points have come to: (r, r), (s, r) and (s, s)."""
        return self._second, self._third, self._fourth

    def add(self, block: GradientBlock, tensors: RestTensors, row: NDArray[np.intp]) -> None:
        """Add a block of p points of whose tensors each has ``row`` (p,)."""
        size, points = len(block.gradients), len(block.weights)
        D = np.ascontiguousarray(block.gradients.reshape(size, 9, points).transpose(2, 1, 0))
        weighted = block.weights[:, None, None] * D
        whole = len(tensors.second) == 1
        second, third, fourth = (
            part if whole else part[row] for part in (tensors.second, tensors.third, tensors.fourth)
        )
        _accumulate(self._second, D, second @ weighted)
        if not (tensors.third.any() or tensors.fourth.any()):
            return  # linear
        pairs = self._products(D)
        _accumulate(self._third, pairs, third @ weighted)
        _accumulate(self._fourth, pairs, fourth @ (block.weights[:, None, None] * pairs))

    def _products(self, D: Array) -> Array:
        """(p, 45, s): [ab, ij] is the coefficient of A_ab.. in A : D_i D_j, A symmetric."""
        left, right = D[:, :, self._left], D[:, :, self._right]
        products = np.empty((len(D), len(PAIRS[0]), len(self._left)))
        for pair, (a, b) in enumerate(zip(*PAIRS, strict=True)):
            np.multiply(left[:, a], right[:, b], out=products[:, pair])
            if a != b:
                products[:, pair] += left[:, b] * right[:, a]
        return products


def _accumulate(total: Array, left: Array, right: Array) -> None:
    """Add Σ leftᵀ right over points and rows of (p, c, m) and (p, c, n) to a total (m, n)."""
    a, b = left.reshape(-1, left.shape[2]), right.reshape(-1, right.shape[2])
    result = dgemm(1.0, a.T, b.T, beta=1.0, c=total, trans_b=1, overwrite_c=1)
    assert result is total or np.shares_memory(result, total)
