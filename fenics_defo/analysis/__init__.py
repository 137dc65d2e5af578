"""Computations on bodies: vibration modes.

The names load on first use: describing a saved mode needs neither DOLFINx nor SLEPc.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.analysis.modes import linear_modes
    from fenics_defo.analysis.motion import describe_motion
    from fenics_defo.analysis.phases import Phases

_HOME = {"Phases": "phases", "describe_motion": "motion", "linear_modes": "modes"}

__all__ = ["Phases", "describe_motion", "linear_modes"]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
