"""What any strain energy gives at rest, F = I, computed from the UFL expression by NumPy alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.core.expr import Expr

from fenics_defo.energy.constants import Constant
from fenics_defo.energy.evaluation import evaluate
from fenics_defo.energy.material import Material, cell_count
from fenics_defo.energy.stress import first_piola, tangent
from fenics_defo.errors import MaterialError

# Cells that are evaluated at once: the tangent's intermediate arrays take some 10 kB a cell.
_BATCH = 512


@dataclass(frozen=True, slots=True)
class RestState:
    """Derivatives of a strain energy at F = I; m is the number of cells of its fields, or 1.

    Args:
        energy: ψ (m,) [J/m³]. Forces do not feel it.
        stress: P = ∂ψ/∂F (m, 3, 3) [Pa].
        tangent: ∂P/∂F (m, 3, 3, 3, 3) [Pa].
    """

    energy: NDArray[np.float64]
    stress: NDArray[np.float64]
    tangent: NDArray[np.float64]


def rest_state(material: Material) -> RestState:
    """Energy, stress and tangent of ``material`` at F = I.

    Raises:
        MaterialError: its energy is no scalar, or holds what has no value at one point.
    """
    rest, cells = _distinct_rest_states(material)
    return RestState(rest.energy[cells], rest.stress[cells], rest.tangent[cells])


def linear_moduli(material: Material, *, rtol: float = 1e-8) -> tuple[Constant, Constant]:
    """Young's modulus and Poisson's ratio that ``material`` linearises to at rest.

    An isotropic solid without stress has A_ijkl = λ δij δkl + μ (δik δjl + δil δjk); then
    E = μ(3λ + 2μ)/(λ + μ) and ν = λ/(2(λ + μ)).

    Args:
        material: any material; its fields may vary from cell to cell.
        rtol: largest accepted stress, and departure from that form, relative to the largest
            entry of A; round-off stays some orders below the default.

    Returns:
        E [Pa] and ν [-]: floats, or (m,) if a constant is a field.

    Raises:
        MaterialError: the energy is no scalar, or has no second derivative at rest, or is
            stressed, not isotropic or not stable (μ and bulk modulus positive) there.
    """
    rest, cells = _distinct_rest_states(material)
    lmbda, mu = _lame(rest.tangent)
    for accepted, problem, value in _conditions(rest, lmbda, mu, rtol):
        if not accepted.all():
            row = int(np.argmin(accepted[cells]))  # the first such cell
            place = "" if len(cells) == 1 else f", in cell {row} (counted from 0)"
            raise MaterialError(f"the strain energy {problem}: {float(value[cells[row]])!r}{place}")
    young, poisson = mu * (3.0 * lmbda + 2.0 * mu) / (lmbda + mu), lmbda / (2.0 * (lmbda + mu))
    if cell_count(material) is None:
        return float(young[0]), float(poisson[0])
    return young[cells], poisson[cells]


def _conditions(
    rest: RestState, lmbda: NDArray[np.float64], mu: NDArray[np.float64], rtol: float
) -> Iterator[tuple[NDArray[np.bool_], str, NDArray[np.float64]]]:
    """Where each demand on ``rest`` is met, what is wrong elsewhere, and by how much."""
    scale = np.abs(rest.tangent).max(axis=(1, 2, 3, 4))
    stress = np.abs(rest.stress).max(axis=(1, 2))
    yield np.isfinite(scale + stress), "has no finite derivatives at rest (F = I)", scale
    yield (
        stress <= rtol * scale,
        "is stressed at rest (F = I), so that the mesh is not its rest shape; add a term that "
        "cancels the stress, such as a multiple of ln J. Largest entry of ∂ψ/∂F [Pa]",
        stress,
    )
    departure = np.abs(rest.tangent - _isotropic(lmbda, mu)).max(axis=(1, 2, 3, 4))
    yield (
        departure <= rtol * scale,
        "is not isotropic at rest, so that no Young's modulus and Poisson's ratio describe it; "
        "see rest_state(material).tangent. Largest departure of ∂²ψ/∂F² [Pa]",
        departure,
    )
    weakest = np.minimum(mu, lmbda + 2.0 / 3.0 * mu)
    yield (
        weakest > 0.0,
        "is not stable at rest: its shear and its bulk modulus must be positive. The smaller [Pa]",
        weakest,
    )


def _distinct_rest_states(material: Material) -> tuple[RestState, NDArray[np.intp]]:
    """Rest states of the d distinct sets of constants, and which of them each cell (m,) has."""
    values = material.parameters
    F = ufl.variable(ufl.Identity(3))
    # The numbers inside the variables are never used: `evaluate` binds the variables' labels.
    symbols = {name: ufl.variable(ufl.as_ufl(1.0)) for name in values}
    energy = material.strain_energy(F, symbols)
    expressions = (
        energy,
        first_piola(material, F, parameters=symbols),
        tangent(material, F, parameters=symbols),
    )
    shape = (cell_count(material) or 1, len(values))
    table = np.empty(shape)
    for column, value in enumerate(values.values()):
        table[:, column] = value
    rows, cells = _distinct(table)
    energy, stress, stiffness = (_at_rest(e, F, list(symbols.values()), rows) for e in expressions)
    return RestState(energy=energy, stress=stress, tangent=stiffness), cells


def _distinct(table: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Distinct rows of ``table`` and the index of each of its rows among them."""
    if table.shape[1] == 0:  # an energy without constants
        return table[:1], np.zeros(len(table), dtype=np.intp)
    rows, cells = np.unique(table, axis=0, return_inverse=True)
    return rows, cells.ravel()


def _at_rest(
    expression: Expr, F: Expr, symbols: Sequence[Expr], rows: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Values of ``expression`` at F = I for each row of constants, some rows at a time."""
    parts = []
    for start in range(0, len(rows), _BATCH):
        batch = rows[start : start + _BATCH]
        values = {F: np.tile(np.eye(3), (len(batch), 1, 1))}
        values |= {symbol: batch[:, column] for column, symbol in enumerate(symbols)}
        parts.append(evaluate(expression, values))
    return np.concatenate(parts)


def _lame(tangents: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means of the entries A_iijj and of the entries A_ijij, i ≠ j; λ and μ if isotropic.

    Each is read from its own entries: the difference of traces would lose μ where λ ≫ μ.
    """
    i, j = np.nonzero(~np.eye(3, dtype=bool))
    return tangents[:, i, i, j, j].mean(axis=1), tangents[:, i, j, i, j].mean(axis=1)


def _isotropic(lmbda: NDArray[np.float64], mu: NDArray[np.float64]) -> NDArray[np.float64]:
    """λ δij δkl + μ (δik δjl + δil δjk), (m, 3, 3, 3, 3)."""
    one = np.eye(3)
    dilation = np.einsum("ij,kl->ijkl", one, one)
    shear = np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
    return np.multiply.outer(lmbda, dilation) + np.multiply.outer(mu, shear)
