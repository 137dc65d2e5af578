"""From a body to a small model of it: bases of displacements, and the forces within their span.

The names load on first use. None of the modules here may have the name of a public one: importing
it would put the module in that one's place.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.reduction.bases import linear_basis, modal_derivative_basis, snapshot_basis
    from fenics_defo.reduction.basis import Basis
    from fenics_defo.reduction.cubature.training import CubatureTraining, train_cubature
    from fenics_defo.reduction.derivatives import modal_derivatives
    from fenics_defo.reduction.direct_force import DirectForce
    from fenics_defo.reduction.force_range import ForceRange, measure_range
    from fenics_defo.reduction.given_fields import basis_from_array, join
    from fenics_defo.reduction.reducing import reduce
    from fenics_defo.reduction.tabulation import tabulate_cubic, tabulate_linear, taylor_force

_HOME = {
    "Basis": "basis",
    "CubatureTraining": "cubature.training",
    "DirectForce": "direct_force",
    "ForceRange": "force_range",
    "basis_from_array": "given_fields",
    "join": "given_fields",
    "linear_basis": "bases",
    "measure_range": "force_range",
    "modal_derivative_basis": "bases",
    "modal_derivatives": "derivatives",
    "reduce": "reducing",
    "snapshot_basis": "bases",
    "tabulate_cubic": "tabulation",
    "tabulate_linear": "tabulation",
    "taylor_force": "tabulation",
    "train_cubature": "cubature.training",
}

__all__ = [
    "Basis",
    "CubatureTraining",
    "DirectForce",
    "ForceRange",
    "basis_from_array",
    "join",
    "linear_basis",
    "measure_range",
    "modal_derivative_basis",
    "modal_derivatives",
    "reduce",
    "snapshot_basis",
    "tabulate_cubic",
    "tabulate_linear",
    "taylor_force",
    "train_cubature",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
