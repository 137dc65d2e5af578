"""The loops in C that everything needs, compiled on their first use for the machine that runs."""

import ctypes
import subprocess
from functools import cache

from fenics_defo.errors import MissingDependencyError
from fenics_defo.fem.jit import architecture
from fenics_defo.fem.native_library import SOURCES, build_library, cache_folder

_FLAGS = ("-O3", "-std=c17", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast")


@cache
def loops(name: str) -> ctypes.CDLL:
    """The library of ``native/<name>.c``.

    Raises:
        MissingDependencyError: it cannot be compiled.
    """
    flags = (*_FLAGS, *architecture())
    try:
        path = build_library(SOURCES / f"{name}.c", flags=flags, folder=cache_folder())
        return ctypes.CDLL(str(path))
    except (OSError, subprocess.CalledProcessError) as error:
        raise MissingDependencyError(
            f"the loops of {name}.c cannot be compiled ({error}): install a C compiler (gcc), "
            "which DOLFINx needs too, and check that its cache, ~/.cache/fenics, can be written"
        ) from error
