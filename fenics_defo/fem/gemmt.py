"""A fast triangular matrix product for MUMPS, put in place before PETSc is loaded.

The OpenBLAS of the DOLFINx wheel (0.3.32) carries out ``?gemmt``, in which MUMPS spends most of a
symmetric factorisation, as one matrix-vector product a column. ``native/gemmt.c`` does the same by
blocks of ``?gemm``: ``workflows/benchmark_modes.py`` shows what it gains. The C compiler that
DOLFINx itself needs builds it once into DOLFINx's own cache. It is an optimisation only: where
anything is missing, OpenBLAS's own routine stays in use.

Set ``FENICS_DEFO_GEMMT=0`` in the environment to leave OpenBLAS's routine in place.
"""

import ctypes
import logging
import os
import subprocess
from pathlib import Path

from fenics_defo.fem.native_library import SOURCES, build_library, cache_folder

_log = logging.getLogger(__name__)
_SOURCE = SOURCES / "gemmt.c"


def build(folder: Path | None = None) -> Path:
    """Compile ``native/gemmt.c`` unless the cache holds it already.

    Args:
        folder: where the library is kept; DOLFINx's cache by default.

    Returns:
        Path of the shared library.

    Raises:
        OSError: no C compiler, or the folder cannot be written.
        subprocess.CalledProcessError: the compiler failed.
    """
    return build_library(_SOURCE, folder=cache_folder() if folder is None else folder)


def load(library: Path, openblas: Path) -> ctypes.CDLL:
    """Load the routine for the whole process, so that PETSc binds to it.

    Args:
        library: what `build` returned.
        openblas: the library whose ``dgemm`` and ``sgemm`` it calls.

    Raises:
        OSError: one of the two cannot be loaded.
        AttributeError: one of the two lacks its routine.
    """
    # Looked up first: a routine that is visible to PETSc but lacks its gemm would crash.
    blas = ctypes.CDLL(str(openblas))
    products = [ctypes.cast(gemm, ctypes.c_void_p) for gemm in (blas.dgemm_, blas.sgemm_)]
    fast = ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    setters = (fast.fenics_defo_set_dgemm, fast.fenics_defo_set_sgemm)
    for setter, gemm in zip(setters, products, strict=True):
        setter.argtypes, setter.restype = [ctypes.c_void_p], None
        setter(gemm)
    return fast


def install(libraries: Path) -> bool:
    """Put the routine in place for a DOLFINx whose shared libraries lie in one folder.

    Has an effect only before PETSc is loaded into the process.

    Args:
        libraries: folder that holds ``libopenblas.so.0``.

    Returns:
        True when the routine is in place.
    """
    openblas = libraries / "libopenblas.so.0"
    if os.environ.get("FENICS_DEFO_GEMMT", "1") == "0" or not openblas.exists():
        return False
    try:
        load(build(), openblas)
    except (OSError, subprocess.SubprocessError, AttributeError, RuntimeError) as error:
        _log.info("OpenBLAS's own gemmt stays in use: %s", error)
        return False
    return True
