"""From a hyperelastic energy to a small model that runs in real time, with the error measured.

Importing this package loads neither FEniCSx nor SciPy: its subpackages load on first use.
"""

import importlib
from types import ModuleType

__version__ = "0.1.0.dev0"

_SUBPACKAGES = (
    "analysis",
    "beams",
    "energy",
    "errors",
    "fem",
    "reduction",
    "runtime",
    "scene",
    "view",
)

__all__ = ["__version__", *_SUBPACKAGES]


def __getattr__(name: str) -> ModuleType:
    if name in _SUBPACKAGES:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
