"""A fast triangular matrix product for MUMPS, put in place before PETSc is loaded.

The OpenBLAS of the DOLFINx wheel (0.3.32) carries out ``?gemmt``, in which MUMPS spends most of a
symmetric factorisation, as one matrix-vector product a column. ``native/gemmt.c`` does the same by
blocks of ``?gemm``: ``workflows/benchmark_modes.py`` shows what it gains. The C compiler that
DOLFINx itself needs builds it once into DOLFINx's own cache. It is an optimisation only: where
anything is missing, OpenBLAS's own routine stays in use.

Set ``FENICS_DEFO_GEMMT=0`` in the environment to leave OpenBLAS's routine in place.
"""

import ctypes
import hashlib
import logging
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

_log = logging.getLogger(__name__)
_SOURCE = Path(__file__).with_name("native") / "gemmt.c"


def _cache_folder() -> Path:
    """DOLFINx's cache of compiled forms (its documented default)."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "fenics"


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
    folder = _cache_folder() if folder is None else folder
    digest = hashlib.sha256(_SOURCE.read_bytes()).hexdigest()[:16]
    library = folder / f"libfenics_defo_gemmt_{digest}.so"
    if library.exists():
        return library
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise FileNotFoundError("no C compiler (cc or gcc) on PATH")
    folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(suffix=".so", dir=folder)
    os.close(handle)
    try:
        command = [*compiler.split(), "-O3", "-shared", "-fPIC", str(_SOURCE), "-o", name]
        subprocess.run(command, check=True, capture_output=True)
        os.replace(name, library)  # ranks and test workers build at the same time: last one wins
    finally:
        Path(name).unlink(missing_ok=True)
    return library


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
