"""Pictures and exports of runtime records.

`write_modes_vtk` and the checks of paths need NumPy only; `mode_picture` and `require_rendering`
load PyVista when they are first asked for.
"""

import importlib
from typing import TYPE_CHECKING, Any

from fenics_defo.view.exports import write_modes_vtk
from fenics_defo.view.paths import check_picture_path, check_vtk_path

if TYPE_CHECKING:
    from fenics_defo.view.offscreen import require_rendering
    from fenics_defo.view.picture import mode_picture

_LAZY = {"mode_picture": "picture", "require_rendering": "offscreen"}

__all__ = [
    "check_picture_path",
    "check_vtk_path",
    "mode_picture",
    "require_rendering",
    "write_modes_vtk",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f"{__name__}.{_LAZY[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
