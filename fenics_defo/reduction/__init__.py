"""From a body to a small model of it: bases of displacements, and the forces within their span.

The names load on first use. None of the modules here may have the name of a public one: importing
it would put the module in that one's place.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.reduction.basis import Basis
    from fenics_defo.reduction.derivatives import modal_derivatives

_HOME = {
    "Basis": "basis",
    "modal_derivatives": "derivatives",
}

__all__ = [
    "Basis",
    "modal_derivatives",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
