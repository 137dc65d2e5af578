"""What runs after FEniCSx has been forgotten: records, reduced models and their files. NumPy only.

The names load on first use: an application that plays a model reads no other module.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.runtime.archive import ArraySpec, read_archive, write_archive
    from fenics_defo.runtime.atomic import atomic_path, check_writable
    from fenics_defo.runtime.comparison import mac
    from fenics_defo.runtime.floating import FloatingBody, FloatingFrame
    from fenics_defo.runtime.forces import CubicForce, ForceLaw, LinearForce, TaylorForce
    from fenics_defo.runtime.integrators import (
        BackwardEuler,
        CentralDifferences,
        ImplicitNewmark,
        ModalFilter,
        SymplecticEuler,
    )
    from fenics_defo.runtime.model import ReducedModel
    from fenics_defo.runtime.model import load_model as load
    from fenics_defo.runtime.modes import DIRECTIONS, NODES_PER_CELL, Modes, load_modes
    from fenics_defo.runtime.outputs import Outputs, Probe

_HOME = {
    "DIRECTIONS": "modes",
    "NODES_PER_CELL": "modes",
    "ArraySpec": "archive",
    "BackwardEuler": "integrators",
    "CentralDifferences": "integrators",
    "CubicForce": "forces",
    "FloatingBody": "floating",
    "FloatingFrame": "floating",
    "ForceLaw": "forces",
    "ImplicitNewmark": "integrators",
    "LinearForce": "forces",
    "ModalFilter": "integrators",
    "Modes": "modes",
    "Outputs": "outputs",
    "Probe": "outputs",
    "ReducedModel": "model",
    "SymplecticEuler": "integrators",
    "TaylorForce": "forces",
    "atomic_path": "atomic",
    "check_writable": "atomic",
    "load": "model",
    "load_modes": "modes",
    "mac": "comparison",
    "read_archive": "archive",
    "write_archive": "archive",
}

__all__ = [
    "DIRECTIONS",
    "NODES_PER_CELL",
    "ArraySpec",
    "BackwardEuler",
    "CentralDifferences",
    "CubicForce",
    "FloatingBody",
    "FloatingFrame",
    "ForceLaw",
    "ImplicitNewmark",
    "LinearForce",
    "ModalFilter",
    "Modes",
    "Outputs",
    "Probe",
    "ReducedModel",
    "SymplecticEuler",
    "TaylorForce",
    "atomic_path",
    "check_writable",
    "load",
    "load_modes",
    "mac",
    "read_archive",
    "write_archive",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_HOME[name]}")
    found = getattr(module, "load_model" if name == "load" else name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
