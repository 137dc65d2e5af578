"""Computations on bodies: vibration modes, statics and dynamics.

The names load on first use: describing a saved mode needs neither DOLFINx nor SLEPc.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fenics_defo.analysis.driver import simulate
    from fenics_defo.analysis.histories import History, Pulse, Ramp, Sine, Step, Table
    from fenics_defo.analysis.initial import Initial, mode_displacement
    from fenics_defo.analysis.integrators import (
        BackwardEuler,
        CentralDifferences,
        ImplicitNewmark,
        Integrator,
        QuasiStatic,
        SymplecticEuler,
    )
    from fenics_defo.analysis.loads import Gravity, Impulse, Load, PointLoad, Pressure, Traction
    from fenics_defo.analysis.modes import linear_modes
    from fenics_defo.analysis.motion import describe_motion
    from fenics_defo.analysis.phases import Phases
    from fenics_defo.analysis.prescribed import Prescribed
    from fenics_defo.analysis.simulation import Simulation
    from fenics_defo.analysis.states import (
        Energies,
        EnergyRecord,
        Equilibrium,
        Motion,
        State,
        StepReport,
        Substep,
    )
    from fenics_defo.analysis.statics import static_equilibrium

_HOME = {
    "BackwardEuler": "integrators",
    "CentralDifferences": "integrators",
    "Energies": "states",
    "EnergyRecord": "states",
    "Equilibrium": "states",
    "Gravity": "loads",
    "History": "histories",
    "ImplicitNewmark": "integrators",
    "Impulse": "loads",
    "Initial": "initial",
    "Integrator": "integrators",
    "Load": "loads",
    "Motion": "states",
    "Phases": "phases",
    "PointLoad": "loads",
    "Prescribed": "prescribed",
    "Pressure": "loads",
    "Pulse": "histories",
    "QuasiStatic": "integrators",
    "Ramp": "histories",
    "Simulation": "simulation",
    "Sine": "histories",
    "State": "states",
    "Step": "histories",
    "StepReport": "states",
    "Substep": "states",
    "SymplecticEuler": "integrators",
    "Table": "histories",
    "Traction": "loads",
    "describe_motion": "motion",
    "linear_modes": "modes",
    "mode_displacement": "initial",
    "simulate": "driver",
    "static_equilibrium": "statics",
}

__all__ = [
    "BackwardEuler",
    "CentralDifferences",
    "Energies",
    "EnergyRecord",
    "Equilibrium",
    "Gravity",
    "History",
    "ImplicitNewmark",
    "Impulse",
    "Initial",
    "Integrator",
    "Load",
    "Motion",
    "Phases",
    "PointLoad",
    "Prescribed",
    "Pressure",
    "Pulse",
    "QuasiStatic",
    "Ramp",
    "Simulation",
    "Sine",
    "State",
    "Step",
    "StepReport",
    "Substep",
    "SymplecticEuler",
    "Table",
    "Traction",
    "describe_motion",
    "linear_modes",
    "mode_displacement",
    "simulate",
    "static_equilibrium",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
